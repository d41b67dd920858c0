"""What the FMI shell refuses of a careless host: missing arguments, long texts, states of others."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p, c_size_t, c_void_p
from typing import Any

import pytest

from .driver import ERROR, GUID, Callbacks, Instance, Refused, library, saved

OURS = "expected a state that fmi2GetFMUstate of this FMU gave"


class Named(Instance):
    """Keeps the instance name that comes with each message."""

    names: tuple[bytes, ...] = ()

    def _log(self, environment: int, name: bytes, status: int, category: bytes, message: bytes) -> None:
        self.names += (name,)
        super()._log(environment, name, status, category, message)


def instantiate(callbacks: Any, guid: bytes | None = GUID.encode()) -> Any:
    return library("allocator").fmi2Instantiate(b"it", 1, guid, None, byref(callbacks), 0, 0)


def test_no_guid_gives_no_instance_but_a_message() -> None:
    with Instance("allocator") as it:
        assert instantiate(it.callbacks, None) is None
        ((status, _, message),) = it.messages
        assert status == ERROR
        assert message.startswith(f"fmi2Instantiate: GUID: expected {GUID}, found none; ")


@pytest.mark.parametrize("missing", ["allocateMemory", "freeMemory"])
def test_callbacks_without_memory_give_no_instance_but_a_message(missing: str) -> None:
    with Instance("allocator") as it:
        callbacks = Callbacks.from_buffer_copy(it.callbacks)
        setattr(callbacks, missing, type(getattr(callbacks, missing))())
        assert instantiate(callbacks) is None
        assert [m for *_, m in it.messages] == [
            "fmi2Instantiate: expected the callbacks allocateMemory and freeMemory, found NULL"
        ]


def test_without_a_logger_errors_are_returned_all_the_same() -> None:
    with Instance("allocator") as it:
        callbacks = Callbacks.from_buffer_copy(it.callbacks)
        callbacks.logger = type(callbacks.logger)()
        lib, handle = library("allocator"), instantiate(callbacks)
        assert lib.fmi2DoStep(handle, 0.0, 0.1, 1) == ERROR
        lib.fmi2FreeInstance(handle)
        assert it.messages == []


@pytest.mark.parametrize(("given", "kept"), [(255, 255), (256, 255), (4000, 255)])
def test_an_instance_name_is_cut_to_255_bytes(given: int, kept: int) -> None:
    it = Named("allocator", name="n" * given, log=True)
    assert it.names == (b"n" * kept,)
    it.free()


def test_a_message_is_cut_to_511_bytes_and_never_within_a_doubled_percent_sign() -> None:
    for text in ("x" * 600, "%" * 600, "x" + "%" * 600, "#" * 300):
        it = Instance("allocator", guid=text)
        assert it.handle is None
        ((_, _, message),) = it.messages
        start, _, rest = message.partition(", found ")
        assert start == f"fmi2Instantiate: GUID: expected {GUID}"
        shown = "".join(2 * c if c in "%#" else c for c in text)
        assert shown.startswith(rest)
        assert len(rest.lstrip("x")) % 2 == 0
        assert 505 <= len(message) <= 511


def test_a_percent_and_a_number_sign_of_a_text_come_doubled_since_a_message_is_a_format() -> None:
    with Instance("plant") as it:
        it.set("epoch", "50% #7")
        with pytest.raises(Refused, match="found '50%% ##7'"):
            it.initialize()


def test_a_category_that_is_null_is_refused_and_one_of_errors_leaves_events_as_they_are() -> None:
    with Instance("allocator", log=True) as it:
        with pytest.raises(Refused, match=r"expected a category of the modelDescription\.xml, found NULL"):
            it.call("SetDebugLogging", 0, 1, (c_char_p * 1)(None))
        it.call("SetDebugLogging", 0, 1, (c_char_p * 1)(b"logStatusError"))
        it.call("Reset")
        assert it.messages[-1] == (0, "logAll", "reset")


def test_a_state_of_another_fmu_is_neither_written_over_nor_serialized() -> None:
    with Instance("controller") as it, Instance("allocator") as other:
        own, foreign = saved(it), saved(other)
        size, room = c_size_t(), ctypes.create_string_buffer(100_000)
        it.call("SerializedFMUstateSize", own, byref(size))
        it.call("SerializeFMUstate", own, room, size.value)
        before = foreign.value
        for call, arguments in (("GetFMUstate", ()), ("DeSerializeFMUstate", (room, size.value))):
            with pytest.raises(Refused, match="expected NULL or a state of this FMU to write over"):
                it.call(call, *arguments, byref(foreign))
        with pytest.raises(Refused, match=OURS):
            it.call("SerializedFMUstateSize", foreign, byref(size))
        with pytest.raises(Refused, match=OURS):
            it.call("SerializeFMUstate", foreign, room, len(room))
        assert foreign.value == before
        it.call("GetFMUstate", byref(own))  # over its own
        other.call("FreeFMUstate", byref(foreign))
        it.call("FreeFMUstate", byref(own))


def test_missing_arguments_of_the_states_functions_are_refused() -> None:
    with Instance("controller") as it:
        own, none = saved(it), c_void_p()
        size, room = c_size_t(), ctypes.create_string_buffer(100_000)
        with pytest.raises(Refused, match="size is NULL"):
            it.call("SerializedFMUstateSize", own, None)
        it.call("SerializedFMUstateSize", own, byref(size))
        for bytes_, n in ((None, size.value), (room, size.value - 1)):
            with pytest.raises(Refused, match="expected a buffer of fmi2SerializedFMUstateSize bytes"):
                it.call("SerializeFMUstate", own, bytes_, n)
        it.call("SerializeFMUstate", own, room, size.value)
        for arguments in ((None, size.value, byref(none)), (room, size.value, None)):
            with pytest.raises(Refused, match="fmi2DeSerializeFMUstate: an argument is NULL"):
                it.call("DeSerializeFMUstate", *arguments)
        assert library("controller").fmi2DeSerializeFMUstate(None, room, size.value, byref(none)) == ERROR
        assert none.value is None
        it.call("FreeFMUstate", byref(own))
