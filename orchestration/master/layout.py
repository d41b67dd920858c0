"""The structures of loop.h, field by field."""

from __future__ import annotations

import ctypes as c

from ..instances.calls import Part

Pointer, Size = c.c_void_p, c.c_size_t


class CPart(c.Structure):
    _fields_ = tuple((name, Size) for name in Part._fields)


class CExchange(c.Structure):
    _fields_ = (
        *((name, Pointer) for name in "function references values places slots buffer".split()),
        ("low", c.c_double),
        ("beyond", c.c_double),
        ("live", CPart),
        ("all", CPart),
        ("type", c.c_int32),
    )


class CGuest(c.Structure):
    _fields_ = (
        ("begun", c.c_int64),
        ("active", c.c_int64),
        ("get_round", Pointer),
        ("set_round", Pointer),
        ("mode", c.c_int32),
        ("turned", c.c_int32 * 3),
    )


class CSeat(c.Structure):
    _fields_ = (
        ("component", Pointer),
        ("do_step", Pointer),
        ("version", c.c_int32),
        ("every", c.c_int64),
        ("step", c.c_double),
        ("sources", Pointer),
        ("factors", Pointer),
        ("offsets", Pointer),
        ("inputs", Pointer),
        ("input_count", Size),
        ("setters", c.POINTER(CExchange)),
        ("setter_count", Size),
        ("getters", c.POINTER(CExchange)),
        ("getter_count", Size),
        ("outputs", Pointer),
        ("output_count", Size),
        ("guest", c.POINTER(CGuest)),
    )


class CDisturbance(c.Structure):
    _fields_ = (
        *((name, c.c_int64) for name in ("first", "last", "behind")),
        *((name, c.c_double) for name in ("value", "frozen")),
        *((name, c.c_int32) for name in ("seat", "place", "kind", "acts", "held")),
    )


class CLoop(c.Structure):
    _fields_ = (
        ("seats", c.POINTER(CSeat)),
        ("seat_count", Size),
        ("parallel", c.c_int32),
        ("bus", Pointer),
        ("delayed", Pointer),
        ("held", Pointer),
        ("delayed_count", Size),
        ("columns", Pointer),
        ("column_count", Size),
        ("rows", Pointer),
        ("interval", c.c_int64),
        ("observed", Pointer),
        ("observed_count", Size),
        ("observed_rows", Pointer),
        ("observed_first", c.c_int64),
        ("numerator", c.c_double),
        ("denominator", c.c_double),
        ("disturbances", c.POINTER(CDisturbance)),
        ("disturbance_count", Size),
        ("count", c.c_int64),
        ("begun", c.c_int64),
        ("seat", c.c_int32),
        ("call", c.c_int32),
        ("part", c.c_int32),
        ("status", c.c_int32),
    )
