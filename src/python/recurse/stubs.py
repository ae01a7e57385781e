"""Generator of type stubs of the plug-ins, from the program's registries: `python3 -m recurse.stubs plug_ins.pyi`."""
import sys

from . import _core
from .plug_ins import KINDS, description, python_name

HEAD = '''from __future__ import annotations

from typing import Any, Iterator, Literal, Sequence, Union

from numpy.typing import ArrayLike

Colour = Union[float, str, Sequence[float]]

class PlugIn:
    info: dict
    parameters: dict[str, Any]
    @property
    def namespace(self) -> str: ...
    @property
    def name(self) -> str: ...
    def __init__(self, info: dict, parameters: dict[str, Any]) -> None: ...

class Namespace:
    def __iter__(self) -> Iterator[str]: ...
    def make(self, name: str | PlugIn, parameters: dict[str, Any]) -> PlugIn: ...

'''

TYPES = {"bool": "bool", "integer": "int", "float": "float", "string": "str", "spectrum": "Colour"}


def parameter_type(spec: dict) -> str:
    """Type annotation of a parameter."""
    if spec["choices"]:
        one = "Literal[" + ", ".join(map(repr, spec["choices"])) + "]"
    else:
        one = TYPES.get(spec["type"], "ArrayLike")
    if spec["count"] != 1:
        one = "Sequence[str | PlugIn]" if spec["type"] == "string" else "ArrayLike"
    return one + (" | PlugIn" if spec["textured"] else "") + " | None"


def stubs() -> str:
    """Text of the stubs."""
    text = HEAD
    infos = _core.plug_ins()
    for namespace in dict.fromkeys(KINDS.values()):
        text += f"class _{namespace}(Namespace):\n"
        for info in infos:
            if KINDS[info["kind"]] != namespace:
                continue
            parameters = "".join(f", {python_name(spec['name'])}: {parameter_type(spec)} = ..."
                                 for spec in info["parameters"] if not spec["ignored"])
            doc = description(info).replace("\\", "\\\\").replace('"""', "'''").replace("\n", "\n        ")
            text += f"    def {python_name(info['name'])}(self{', *' + parameters if parameters else ''}) -> PlugIn:\n"
            text += f'        """{doc}\n        """\n'
        text += f"\n{namespace}: _{namespace}\n\n"
    return text


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as out:
        out.write(stubs())
