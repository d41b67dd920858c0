"""What the fields of the models mean: the text under each of them, read when a schema or a message asks for it."""

from __future__ import annotations

import ast
import inspect
import itertools
from collections.abc import Mapping
from functools import cache

from pydantic import BaseModel


@cache
def descriptions(model: type[BaseModel]) -> Mapping[str, str]:
    """The descriptions of a model's fields by their names, inherited ones included.

    Pydantic reads them too, by `use_attribute_docstrings`, but for every model at import: 30 ms of each command.
    """
    found: dict[str, str] = {}
    for base in reversed(model.__bases__):
        if issubclass(base, BaseModel) and base is not BaseModel:
            found |= descriptions(base)
    (definition,) = ast.parse(inspect.getsource(model)).body
    assert isinstance(definition, ast.ClassDef)
    for field, text in itertools.pairwise(definition.body):
        match field, text:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str() as meaning)):
                found[name] = inspect.cleandoc(meaning)
    return found
