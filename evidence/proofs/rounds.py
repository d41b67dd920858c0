"""How often a loop that counts goes round: Eva proves the bound of loops.yaml, as a check before the loop.

The check is written into a copy of the C, in the line of the loop, so that all places stay; it assumes nothing.

Shows FC-2.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

import yaml

from orchestration import InputError

FILE = Path(__file__).with_name("loops.yaml")
FLIGHT_CODE = ("allocator", "controller", "estimator", "supervisor", "fmus")
_ASSUMES = re.compile(r"\badmit\b|\baxiom\b|\blemma\b|\binvariant \w+:|\\false")
CHANGES = r"(?:\+\+|--)(?:\w+(?:->|\.))*{name}\b|\b{name} *(?:\+\+|--|(?:[-+*/%&|^]|<<|>>)?=[^=])|&{name}\b"
"""How a body changes a variable or a member."""
_NUMBER = r"(?:(?! && )[\w.()&*+ -]|->)+"
_UP = re.compile(rf"for \((?:int|int32_t|size_t) (\w+) = ({_NUMBER}); \1 (<=?) ({_NUMBER})(?: && [^;]+)?; \+\+\1\)")
_DOWN = re.compile(rf"for \((?:int|int32_t) (\w+) = ({_NUMBER}); \1 (>=?) ({_NUMBER})(?: && [^;]+)?; --\1\)")


def closing(text: str, at: int, pair: str) -> int:
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] == pair[0]) - (text[i] == pair[1])
        if depth == 0:
            return i
    raise InputError(f"no {pair[1]} closes {text[at : at + 40]!r}")


def bounds() -> dict[tuple[str, str], int]:
    """The most rounds of each loop of loops.yaml, by file and head. Raises InputError where one stands twice."""
    known: dict[tuple[str, str], int] = {}
    for entry in yaml.safe_load(FILE.read_text("utf-8")):
        for head in entry["loops"]:
            if (place := (entry["file"], head)) in known:
                raise InputError(f"{FILE.name}: {entry['file']}: {head} stands twice")
            known[place] = entry["most"]
    return known


def has_or(condition: str) -> bool:
    """Returns whether a condition has an alternative outside parentheses: it then bounds no counter."""
    bare = condition
    while (less := re.sub(r"\([^()]*\)", "", bare)) != bare:
        bare = less
    return "||" in bare


def counts(head: str, body: str) -> str:
    """Returns how often a loop goes round at most, as a term of C; empty where its head does not say, or its body
    counts.
    """
    if found := _UP.fullmatch(head):
        i, first, sign, end = found.groups()
    elif found := _DOWN.fullmatch(head):
        i, end, sign, first = found.groups()
    else:
        return ""
    named = {i, *re.findall(r"[A-Za-z_]\w*", end), *re.findall(r"[A-Za-z_]\w*", first)}
    if has_or(head[len("for (") : -1]) or any(re.search(CHANGES.format(name=name), body) for name in named):
        return ""
    return f"({end}) - ({first})" + (" + 1" if "=" in sign else "")


def marked(text: str, most: dict[str, int]) -> tuple[str, dict[int, str]]:
    """The text with a check before each loop that counts, and the head of each such loop by its line.

    `most` are the bounds of the file's loops, by their heads.
    """
    heads: dict[int, str] = {}
    bare = re.sub(r"/\*.*?\*/|//[^\n]*", lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.DOTALL)
    for found in reversed(list(re.finditer(r"\bfor \(", bare))):
        end = closing(bare, found.end() - 1, "()") + 1
        head = " ".join(bare[found.start() : end].split())
        begin = bare.find("{", end)
        if head in most and (term := counts(head, bare[begin : closing(bare, begin, "{}")])):
            note = re.search(r"(?:/\*@ loop(?:(?!/\*).)*\*/|//@ loop[^\n]*)\s*\Z", text[: found.start()], re.DOTALL)
            at = note.start() if note else found.start()
            heads[bare.count("\n", 0, at) + 1] = head
            text = f"{text[:at]}/*@ check {term} <= {most[head]}; */ {text[at:]}"
    return text, heads


def c_of(root: Path) -> Iterator[tuple[str, str]]:
    """The C of the packages in `root` that flight code is made of: each file's name in it, with slashes, and text."""
    for package in FLIGHT_CODE:
        for path in sorted(p for p in (root / package).rglob("*") if p.suffix in (".c", ".h")):
            yield path.relative_to(root).as_posix(), path.read_text("utf-8")


_PROMISES = r"#ifdef __FRAMAC__\n(?:/\*[^\n]*\*/\n)*(?:#define (?:[^\n]*\\\n)+[^\n]*\n)+(?:/\*[^\n]*\*/\n)*#endif"
_ANNOTATIONS = r"#ifdef PROOF_\w+\n(?: *//@[^\n]*\n|/\*@(?:(?!\*/).)*\*/\n)+#endif"
_ELSEWHERE = r"#ifdef PROOF_APART\nextern [^;{}]*;\n#else\nstatic inline "
_APART = re.compile(f"{_PROMISES}|{_ANNOTATIONS}|{_ELSEWHERE}", re.DOTALL)
"""What a proof may read and a compiler not: macros of contracts, annotations, and prototypes for what another program
proves."""


_BY_COMPILER = re.compile(r"\b(?:asm|__asm__|__builtin_\w+|__attribute__|ghost|inductive|long|short)\b")
"""What the proof and a compiler may take for other things: the width of `long` is that of the processor."""
_CONDITIONS = re.compile(
    r"ifndef \w+_H|ifdef (?:PROOF_\w+|__FRAMAC__)|if (?:ALLOCATOR_BOUNDED|ESTIMATOR)_WHEELS > 1"
    r"|if defined\(ESTIMATOR_WITHOUT_BANK\)"
)
_NO_BLOCK = re.compile(
    r"/shell\d?/|^fmus/(?:kit|link|python|telemetry)/|/freestanding/(?:math|string)\.h|/freestanding/memory\.c"
)
"""C round the blocks, which is another one for each system and compiler."""


def refuse_assumptions(root: Path) -> None:
    """Raises InputError where the C of `root` asks a proof to take something as given, has a goto, or is another C for
    the proof than for the compiler, or for one compiler than for another."""
    for name, text in c_of(root):
        other = re.search(r"#undef|__FRAMAC__|\bPROOF_\w+", _APART.sub("", text))
        if other and "/shell" not in name:
            raise InputError(f"{name}: {other[0]}: expected the C that flies, and contracts or assertions beside it")
        given = [note for note in re.findall(r"/\*@.*?\*/|//@[^\n]*", text, re.DOTALL) if _ASSUMES.search(note)]
        if given or re.search(r"\bgoto \w+;", text):
            raise InputError(f"{name}: {given[0] if given else 'goto'}: expected a proof, not an assumption")
        if not _NO_BLOCK.search(name):
            _refuse_compilers(name, text)


def _refuse_compilers(name: str, text: str) -> None:
    bare = re.sub(r"/\*[^@].*?\*/|//[^@\n][^\n]*", "", re.sub(r'"[^"\n]*"', '""', text), flags=re.DOTALL)
    conditions = re.findall(r"^ *# *((?:if|elif)[^\n]*?) *$", bare, re.MULTILINE)
    other = [c for c in conditions if not _CONDITIONS.fullmatch(c)] or _BY_COMPILER.findall(bare)
    if other:
        raise InputError(f"{name}: {other[0]}: expected the same C for each compiler and processor")


def copy(root: Path, into: Path) -> dict[tuple[str, int], str]:
    """Copies the C of `root` with the checks; returns `file: head` of each checked loop by its file and line."""
    shutil.rmtree(into, ignore_errors=True)
    places: dict[tuple[str, int], str] = {}
    known = bounds()
    for name, text in c_of(root):
        most = {head: n for (file, head), n in known.items() if file == name}
        new, heads = marked(text, most)
        (into / name).parent.mkdir(parents=True, exist_ok=True)
        (into / name).write_text(new, "utf-8")
        places |= {(name, line): f"{name}: {head}" for line, head in heads.items()}
    return places


def proved(results: Iterable[tuple[tuple[str, bool], ...]]) -> dict[str, bool]:
    """Returns whether each checked loop is proved, in each program that has it."""
    found: dict[str, bool] = {}
    for rounds in results:
        for loop, holds in rounds:
            found[loop] = found.get(loop, True) and holds
    return found
