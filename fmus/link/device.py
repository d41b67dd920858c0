"""The device's end of the link in Python: bytes in, bytes out. It needs nothing but Python; a kit holds a copy of it.

device = Device(Ports(...), sample)
answers = device.receive(bytes_from_the_line)

`sample(parameters, memory, inputs, t, h)` returns the outputs by name, or raises Refused.

Longer than 250 lines: a kit copies it as the one file that a device in Python needs.
"""

from __future__ import annotations

import struct
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

VERSION = 2
HELLO, PARAMETERS, START, STEP, END, ANSWER, REFUSED = 1, 2, 3, 4, 5, 0x80, 0xFF
NOT_STARTED, OTHER_INTERFACE, WRONG_SIZE, BLOCK_REFUSES, IN_USE = 1, 2, 3, 4, 5
LEASE_OF_HELLO, LEASE = 0.2, 2.0
"""Seconds after a run's last request from which another run may take the device; the first, where that has told no
parameters."""
BIG_ENDIAN, SINGLE = 1, 2
MARK = b"\xa5\x5a"
_HEAD = struct.Struct("<2sBBIIH")
GREETING = struct.Struct("<BB8s32s8s")
_CODES = {"real": "d", "integer": "i", "enumeration": "i", "boolean": "?"}


class Refused(Exception):
    """A value that the block does not accept: its text goes to the other end, which stops the run."""


@dataclass(frozen=True)
class Field:
    """A variable on the line. `start` has its shape; an item of an enumeration is its number, from 1 on."""

    name: str
    type: str
    shape: tuple[int, ...] = ()
    start: Any = None
    text_size: int = 0


@dataclass(frozen=True)
class Ports:
    """An interface on the line."""

    name: str
    hash: bytes
    parameters: tuple[Field, ...]
    inputs: tuple[Field, ...]
    outputs: tuple[Field, ...]

    @property
    def largest(self) -> int:
        """Bytes of no frame are more."""
        return (
            _HEAD.size + 4 + 16 + max(128, *(Layout(f, 0).size for f in (self.parameters, self.inputs, self.outputs)))
        )


@dataclass(frozen=True)
class Frame:
    """A request or an answer."""

    version: int
    type: int
    session: int
    sequence: int
    payload: bytes


def frame(type_: int, session: int, sequence: int, payload: bytes) -> bytes:
    """The bytes of a frame."""
    body = _HEAD.pack(MARK, VERSION, type_, session, sequence, len(payload)) + payload
    return body + struct.pack("<I", zlib.crc32(body[2:]))


class Reader:
    """Finds frames in a stream of bytes, whatever stands between them."""

    def __init__(self, largest: int) -> None:
        self._held, self._largest = bytearray(), largest

    def turn(self) -> None:
        """Another datagram or sender follows: what was begun before is ended by no byte of it."""
        self._held.clear()

    def feed(self, data: bytes) -> Iterator[Frame]:
        """The frames that end in these bytes. `largest` bounds what is waited for after a damaged size."""
        self._held += data
        while True:
            start = self._held.find(MARK)
            del self._held[: len(self._held) - (self._held[-1:] == MARK[:1]) if start < 0 else start]
            if len(self._held) < _HEAD.size:
                return
            _, version, type_, session, sequence, size = _HEAD.unpack_from(self._held)
            whole = _HEAD.size + size + 4
            if whole <= self._largest and len(self._held) < whole:
                return
            if whole <= self._largest and zlib.crc32(self._held[2 : whole - 4]) == int.from_bytes(
                self._held[whole - 4 : whole], "little"
            ):
                payload = bytes(self._held[_HEAD.size : whole - 4])
                del self._held[:whole]
                yield Frame(version, type_, session, sequence, payload)
            else:
                del self._held[:1]


class Layout:
    """Reads and writes the values of a record in a format."""

    def __init__(self, fields: tuple[Field, ...], format_: int) -> None:
        codes = {**_CODES, "real": "f"} if format_ & SINGLE else _CODES
        parts = [f"{f.text_size}s" if f.text_size else f"{_count(f)}{codes[f.type]}" for f in fields]
        self._fields = fields
        self._struct = struct.Struct((">" if format_ & BIG_ENDIAN else "<") + "".join(parts))
        self.size = self._struct.size

    def unpack(self, data: bytes) -> SimpleNamespace:
        values = iter(self._struct.unpack(data))
        return SimpleNamespace(**{f.name: _nested(values, f) for f in self._fields})

    def pack(self, values: Mapping[str, Any]) -> bytes:
        return self._struct.pack(*(leaf for f in self._fields for leaf in _flat(values[f.name])))


def _count(field: Field) -> int:
    count = 1
    for n in field.shape:
        count *= n
    return count


def _nested(values: Iterator[Any], field: Field, axis: int = 0) -> Any:
    """A scalar, a list, or a list of rows."""
    if axis == len(field.shape):
        value = next(values)
        return value.split(b"\0")[0].decode("utf-8", "replace") if field.text_size else value
    return [_nested(values, field, axis + 1) for _ in range(field.shape[axis])]


def _flat(value: Any) -> Iterator[Any]:
    if isinstance(value, str):
        yield value.encode()
    elif hasattr(value, "__iter__"):
        for item in value:
            yield from _flat(item)
    else:
        yield value


Sample = Callable[[SimpleNamespace, SimpleNamespace, SimpleNamespace, float, float], Mapping[str, Any]]


class Device:
    """Meets each request once and answers it; one that comes again has the same answer, one that comes
    late has none. While a run uses the device, the hello of another is refused, named and changes nothing.
    """

    def __init__(self, ports: Ports, sample: Sample) -> None:
        self._ports, self._sample = ports, sample
        self._reader = Reader(ports.largest)
        self._greeted = self._fits = self._started = False
        self._session = self._sequence = self._format = 0
        self._parameters: SimpleNamespace | None = None
        self._memory = SimpleNamespace()
        self._answer, self._token, self._heard = b"", bytes(8), 0.0
        self._sender = self._stranger = ""

    def receive(self, data: bytes, sender: str = "", turned: bool = False) -> bytes:
        """The answers to the requests that end in these bytes, which another datagram or sender begins where
        `turned`."""
        if turned:
            self._reader.turn()
        self._sender = sender
        return b"".join(map(self._met, self._reader.feed(data)))

    def _met(self, request: Frame) -> bytes:
        if not HELLO <= request.type <= END:
            return b""
        if request.type == HELLO and self._is_strange(request):
            return self._refused(request)
        same = self._greeted and request.session == self._session
        if same and request.sequence <= self._sequence:
            return self._answer if request.sequence == self._sequence else b""
        if self._greeted and not same and request.type != HELLO:
            return b""
        self._heard = time.monotonic()
        if request.type == END:
            self._greeted = self._started = False
            return b""
        if request.type == HELLO:
            type_, payload = self._greet(request, same)
        else:
            try:
                type_, payload = request.type | ANSWER, self._work(request)
            except _Refusal as refusal:
                type_, payload = REFUSED, struct.pack("<B96s", refusal.code, refusal.text.encode("ascii", "replace"))
        self._sequence = request.sequence
        self._answer = frame(type_, request.session, request.sequence, payload)
        return self._answer

    def _is_strange(self, hello: Frame) -> bool:
        """Returns whether the hello is of another run than that which uses the device."""
        lease = LEASE_OF_HELLO if self._parameters is None else LEASE
        return self._greeted and _token(hello) != self._token and time.monotonic() - self._heard < lease

    def _refused(self, hello: Frame) -> bytes:
        """Names the run that uses the device, and the stranger."""
        why = f"in use by run {self._token.hex()}; free when that ends, or {LEASE:g} s after its last request"
        if self._sender != self._stranger:
            print(f"refused {self._sender or 'another program'}: {why}", file=sys.stderr, flush=True)
            self._stranger = self._sender
        return frame(REFUSED, hello.session, hello.sequence, struct.pack("<B96s", IN_USE, why.encode()))

    def _greet(self, request: Frame, same: bool) -> tuple[int, bytes]:
        right = request.version == VERSION and len(request.payload) == GREETING.size
        if not same:
            self._started, self._parameters = False, None
        self._greeted, self._session, self._token = True, request.session, _token(request)
        self._fits = right and request.payload[2:10] == self._ports.hash
        self._format = request.payload[0] & (BIG_ENDIAN | SINGLE) if right else 0
        name = self._ports.name.encode()
        greeting = GREETING.pack(self._format, self._started, self._ports.hash, name, self._token)
        return HELLO | ANSWER, greeting

    def _work(self, request: Frame) -> bytes:
        if not self._greeted or (request.type == STEP and not self._started):
            raise _Refusal(NOT_STARTED, "not started")
        if not self._fits:
            raise _Refusal(OTHER_INTERFACE, f"built for the interface {self._ports.name}")
        times = struct.Struct((">" if self._format & BIG_ENDIAN else "<") + "dd")
        fields = self._ports.parameters if request.type == PARAMETERS else self._ports.inputs
        layout, head = Layout(fields, self._format), 0 if request.type == PARAMETERS else times.size
        if len(request.payload) != head + layout.size:
            raise _Refusal(WRONG_SIZE, "another number of bytes than the interface has")
        values = layout.unpack(request.payload[head:])
        if request.type == PARAMETERS:
            self._parameters = values
            return b""
        if self._parameters is None:
            raise _Refusal(NOT_STARTED, "not started")
        t, h = times.unpack_from(request.payload)
        if request.type == START:
            self._memory, h = SimpleNamespace(), 0.0
        try:
            outputs = self._sample(self._parameters, self._memory, values, t, h)
        except Refused as refused:
            raise _Refusal(BLOCK_REFUSES, str(refused)) from None
        self._started = True
        return times.pack(t + h, 0.0)[:8] + Layout(self._ports.outputs, self._format).pack(outputs)


def _token(hello: Frame) -> bytes:
    return hello.payload[-8:] if len(hello.payload) == GREETING.size else bytes(8)


class _Refusal(Exception):
    def __init__(self, code: int, text: str) -> None:
        self.code, self.text = code, text
