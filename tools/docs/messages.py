"""The page of messages: every refusal and warning of the host tools, as the source has it, under what to do about it.

collected()  messages by their place: what is given to an exception or to `stop`, the statuses and events of the C core
page()       with the cures of messages.toml; a message that no cure speaks of is an error
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Iterator

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib  # type: ignore[no-redef]

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "tools" / "kalmanq"
RAISES = re.compile(r"(?<!Value)(?<!Attribute)(?<!Implemented)(?<!Type)Error$|^stop$|\.error$|\._refused$|Warning$|\.warn$"
                    r"|^(NoFormula|Untraced|NotProven|NotClosed|NoCompiler|_Refused|Singular|Overflow)$")
C_CORE = re.compile(r"case (KQ_\w+):\s*return \"([^\"]+)\"|lib\.(KQ_EVENT_\w+): \(\"[^\"]+\", \"([^\"]+)\"\)")


def collected() -> dict[str, str]:
    """Message, names in braces for what is put in: the file that says it"""
    found: dict[str, str] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        constants = dict(_constants(tree))
        for one in ast.walk(tree):
            if isinstance(one, ast.Call) and RAISES.search(_called(one.func)):
                for text in filter(None, (template(given, constants) for given in one.args)):
                    found.setdefault(text, str(path.relative_to(PACKAGE)))
    for path in (ROOT / "src/messages/status.h", PACKAGE / "core.py"):
        for status, text, event, said in C_CORE.findall(path.read_text(encoding="utf-8")):
            if status != "KQ_OK":
                found[text or said] = status or event
    return found


def _constants(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for one in tree.body:
        if isinstance(one, ast.Assign) and isinstance(one.value, ast.Constant) and isinstance(one.value.value, str):
            yield one.targets[0].id, one.value.value  # type: ignore[attr-defined]


def _called(function: ast.expr) -> str:
    return f".{function.attr}" if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def template(given: ast.expr, constants: dict[str, str]) -> str:
    """A text of several words, with {name} for what is put in"""
    if isinstance(given, ast.Constant) and isinstance(given.value, str):
        text = given.value
    elif isinstance(given, ast.Name):
        text = constants.get(given.id, "")
    elif isinstance(given, ast.JoinedStr):
        text = "".join(_part(part, constants) for part in given.values)
    else:
        return ""
    return " ".join(text.replace("`", "'").split()) if len(text.split()) > 2 else ""


def _part(part: ast.expr, constants: dict[str, str]) -> str:
    if isinstance(part, ast.Constant):
        return str(part.value)
    value = part.value  # type: ignore[attr-defined]
    if isinstance(value, ast.Name):
        return constants.get(value.id, f"{{{value.id}}}")
    names = [one.attr if isinstance(one, ast.Attribute) else one.id for one in ast.walk(value) if isinstance(one, (ast.Attribute, ast.Name))]
    return f"{{{names[0] if isinstance(value, ast.Attribute) else '...'}}}"


def told() -> dict:
    return tomllib.loads((ROOT / "tools/docs/messages.toml").read_text(encoding="utf-8"))


def sorted_by_cure(messages: dict[str, str]) -> tuple[list[tuple[dict, list[str]]], list[str]]:
    """Each cure with its messages, the first cure that speaks of one; and messages without any"""
    parts: list[tuple[dict, list[str]]] = [(one, []) for one in told()["cure"]]
    left = [f"[status] {name}" for name in {*told()["status"]} ^ {one for one in messages.values() if one.startswith("KQ_")}]
    for text in sorted(messages):
        home = next((found for cure, found in parts if any(re.search(says, text) for says in cure["says"])), left)
        home.append(text)
    return parts, left


def anchors(texts: list[str]) -> dict[str, str]:
    """Of each message, from its fixed words; a number follows where others have the same"""
    made: dict[str, str] = {}
    for text in texts:
        name = "-".join(re.findall(r"[a-z0-9]+", re.sub(r"\{[^}]*\}", " ", text.lower())))[:60].strip("-") or "message"
        many = sum(re.sub(r"-\d+$", "", one) == name or one == name for one in made.values())
        made[text] = f"{name}-{many + 1}" if many else name
    return made


def _alone(place: str) -> str:
    return f" (`{place}`): {told()['status'][place]}" if place.startswith("KQ_") else ""


def page() -> str:
    collection = collected()
    parts, left = sorted_by_cure(collection)
    names = anchors(sorted(collection))
    if left:
        raise SystemExit("messages without a cure in tools/docs/messages.toml:\n" + "\n".join(left))
    made = ["# Messages\n\nA message of the host tools says what is wrong, where, and after the colon what to do. Here is each one, with more on what to "
            "do. `{name}` stands for what the message puts in. Search for words of yours."]
    for cure, found in parts:
        lines = (f'- <a id="{names[text]}"></a>`` {text} ``{_alone(collection[text])}' for text in found)
        made.append(f"## {cure['title']}\n\n{cure['do']}\n\n" + "\n".join(lines))
    return "\n\n".join(made) + "\n"
