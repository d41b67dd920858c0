"""The instances of a run, which stand by for the next run of the same scenario: that one resets them.

They are this project's own native FMUs, whose reset leaves nothing behind, and nothing stands before them that has a state of
its own. All others are instantiated for each run. What `Flight` keeps for its flights is apart from this.
"""

from __future__ import annotations

import atexit
from collections.abc import Hashable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

from ..errors import BlockError
from ..instances.block import Block, Instance
from ..instances.slave import Slave
from ..master.bus import Bus
from .open import Opened


@dataclass
class Standby:
    """Instances in their first state."""

    opened: Opened
    key: Hashable
    """What else the layout of the bus depends on."""
    instances: Mapping[str, Instance]
    blocks: Mapping[str, Block]
    """The same as the master sees them."""
    stack: ExitStack
    """Ends them."""
    bus: Bus | None = None
    """As the master lays it out in the first run."""
    sound: bool = False
    """Whether the run came to its end, so that they can be reset."""

    @property
    def stays(self) -> bool:
        """Whether the next run may have them."""
        own = all(isinstance(block, Slave) and block.shared for block in self.instances.values())
        bare = all(self.blocks[name] is block for name, block in self.instances.items())
        return self.sound and own and bare and not self.opened.plan.faults.disturbances


_waiting: list[Standby] = []
"""One at most, that of the last run."""


@contextmanager
def standby(opened: Opened, key: Hashable, verbose: bool) -> Iterator[Standby]:
    """The instances of an opened scenario. Raises InputError. `verbose`: what they log is printed, and they are for this run alone."""
    found = None if verbose else _taken(opened, key)
    if found is None:
        stack = ExitStack()
        with stack:
            instances = opened.instantiate(stack, verbose)
            blocks = {name: opened.adapted(block) for name, block in instances.items()}
            found = Standby(opened, key, instances, blocks, stack.pop_all())
    with found.stack as stack:
        yield found
        if not verbose and found.stays:
            found.stack = stack.pop_all()
            _close()
            _waiting.append(found)
            atexit.unregister(_close)
            atexit.register(_close)  # the last one, which is called first: before the libraries are unloaded


def _taken(opened: Opened, key: Hashable) -> Standby | None:
    """What the last run has left, reset; None where it was another scenario's."""
    try:
        found = _waiting.pop()
    except IndexError:  # nothing is there, or another thread was quicker
        return None
    if found.opened is opened and found.key == key:
        try:
            for block in found.instances.values():
                block.reset()
        except BlockError:
            pass
        else:
            found.sound = False
            return found
    found.stack.close()
    return None


def _close() -> None:
    """Ends what stands by."""
    with suppress(IndexError):  # another thread may take what stands by
        while True:
            _waiting.pop().stack.close()
