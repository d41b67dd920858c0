"""Metrics in Python: the code of a function, found once and sent to the workers.

It runs as the user does, without any guard.
"""

from __future__ import annotations

import hashlib
import sys
import threading
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from symtable import symtable
from types import ModuleType

from ...errors import InputError, hint
from ...expectations.metrics import Function
from ...foreign import told

_loading = threading.Lock()


@dataclass(frozen=True)
class Code:
    """A module beside the campaign file, as text; or one that is installed, where `text` is None."""

    module: str
    file: str
    text: str | None

    @property
    def sha256(self) -> str:
        """Returns the digest of its text; of an installed module that of the file that was imported."""
        content = self.text.encode() if self.text is not None else Path(self.file).read_bytes() if self.file else b""
        return hashlib.sha256(content).hexdigest()

    def imported(self) -> ModuleType:
        """Returns the module, made of the text or imported."""
        if self.text is None:
            return import_module(self.module)
        name = f"metrics_{self.sha256}"  # of its own, since other modules may be called as the file is
        module = ModuleType(name)
        module.__file__ = self.file
        with _loading:
            sys.modules[name] = module  # dataclasses look there for the module of a class
            try:
                exec(compile(self.text, self.file, "exec"), module.__dict__)
            except BaseException:
                del sys.modules[name]
                raise
        return module


class NotLoaded(InputError):
    """A module of metrics cannot be loaded."""

    def __init__(self, module: str, message: str) -> None:
        super().__init__(message)
        self.module = module


def find(reference: str, folder: Path, place: str, loads: bool = True) -> Code:
    """Returns the code of `module:function`: `module.py` beside the campaign file, else an installed module.

    `loads`: whether the module is run, as campaigns do that fly; else its text is looked at. Raises InputError.
    """
    name, _, function = reference.partition(":")
    path = folder.joinpath(*name.split(".")).with_suffix(".py")
    try:
        if path.is_file():
            code = Code(name, str(path), path.read_text("utf-8"))
            names = _callables(code.imported()) if loads else _stated(code)
        elif loads:
            names = _callables(import_module(name))
            code = Code(name, getattr(sys.modules[name], "__file__", None) or "", None)
        elif find_spec(name.partition(".")[0]) is None:
            raise ModuleNotFoundError(name=name)
        else:
            return Code(name, "", None)
    except ModuleNotFoundError as error:
        missing = error.name or name
        if not path.is_file() and (name == missing or name.startswith(f"{missing}.")):
            why = f"there is no file {path}, and no installed module of this name"
            why += "; remedy: write the file, or install the module"
        else:
            why = f"it imports {missing!r}, which is not installed; remedy: pip install it"
        raise NotLoaded(name, f"{place}: the module {name!r} cannot be loaded: {why}") from None
    except SyntaxError as error:
        at = f"{error.filename}:{error.lineno}: {error.msg}"
        raise NotLoaded(name, f"{place}: the module {name!r} cannot be loaded: {at}") from None
    except BaseException as error:
        why = told(error)
        raise NotLoaded(name, f"{place}: the module {name!r} cannot be loaded: {why}, in {path}") from None
    if function not in names:
        known = hint(function, (n for n in names if not n.startswith("_")))
        raise InputError(f"{place}: {path.name if code.text else name} has no function {function!r}{known}")
    return code


def _callables(module: ModuleType) -> list[str]:
    return [name for name in dir(module) if callable(getattr(module, name))]


def _stated(code: Code) -> list[str]:
    """Returns the names that a module's text gives a value, without running it."""
    return [symbol.get_name() for symbol in symtable(code.text or "", code.file, "exec").get_symbols()]


def functions(codes: dict[str, Code]) -> dict[str, Function]:
    """Returns the functions by their references, `module:function`; a module that several name is loaded once."""
    modules: dict[str, ModuleType] = {}
    for code in codes.values():
        if code.module not in modules:
            modules[code.module] = code.imported()
    return {reference: getattr(modules[code.module], reference.partition(":")[2]) for reference, code in codes.items()}
