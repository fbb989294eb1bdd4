"""What is refused is told with the line and column of it, for each kind of file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from actspec.audit.places import json_places, toml_places
from actspec.cli.main import main
from actspec.diagnostics import Path as Way

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SOUND = '<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody></mujoco>'
LONG = "9" * 5000
SHAPE = '{"format": "actspec-baseline/1", "findings": ['
ENTRY = '{"code": "A", "file": "b", "joint": "", "count": 1, "value": %s}'
LOCK = '{"format": "actspec-lock/1", "versions": {},\n "files": {\n'
ROBOT = ' "a.xml": {"kind": "mjcf", "robots": {"r": {\n "settings": {}, "hash": "0",\n "joints": '

REFUSED: dict[str, tuple[str, bytes | str, list[str]]] = {
    "cfg: syntax": ("a.py", "X = 1\nX = = 2\n", ["2:5"]),
    "cfg: null byte": ("a.py", "X = 1\nY = '\0'\n", ["2:6"]),
    "cfg: not UTF-8": ("a.py", b"X = 1\n\xc3\xa4 = '\xff'\n", ["2:6"]),
    "cfg: other encoding": ("a.py", "# coding: punycode\n", ["1:11"]),
    "deploy: syntax": ("a.yaml", "kp: [1,\nkd: }\n", ["2:5"]),
    "deploy: not UTF-8": ("a.yaml", b"kp: {a: 1}\nkd: {\xff: 1}\n", ["2:6"]),
    "deploy: control": ("a.yaml", "kp: 1\nkd: \x01\n", ["2:5"]),
    "deploy: deep": ("a.yaml", f"kp:\n {'[' * 50}{']' * 50}\n", ["2:41"]),
    "deploy: alias": ("a.yaml", "kp: 1\nkd: *x\n", ["2:5"]),
    "settings: syntax": ("actspec.toml", "[audit]\nselect = [1 2]\n", ["2:13"]),
    "settings: end": ("actspec.toml", "[audit]\nselect = [1,\n\n", ["2:12"]),
    "settings: not UTF-8": ("actspec.toml", b"[audit]\nx = '\xff'\n", ["2:6"]),
    "settings: digits": ("actspec.toml", f"[audit]\nx = {LONG}\n", ["2:5"]),
    "settings: deep": ("actspec.toml", f"[audit]\nx = {'[' * 3000}", ["2:105"]),
    "settings: key": ("actspec.toml", "[audit]\n\n selct = []\n", ["3:2"]),
    "settings: item": ("actspec.toml", '[audit]\nignore = ["DMP101",\n  "DMQ", "LIN9"]\n', ["3:3", "3:10"]),
    "settings: glob": ("actspec.toml", "[audit.per-file-ignores]\n'a.*' = ['ALL']\n\"b.\\u0041\" = 1", ["3:1"]),
    "settings: option": ("actspec.toml", "[audit.rules.DMP103]\nratoi = 1\n", ["2:1"]),
    "settings: figure": ("actspec.toml", f"[audit]\nrules.DMP103.share = 1{'0' * 400}", ["2:14"]),
    "settings: header": ("actspec.toml", '[audit]\n[ adit."rules".LIM101]\n[[1]]\n', ["2:3", "3:3"]),
    "settings: version": ("actspec.toml", 'audit = {versions = {mujoco = 3, isaclab = "2"}}', ["1:22", "1:34"]),
    "settings: table": ("pyproject.toml", "[tool.x]\na = 1\n[tool]\nactspec.audit = 3\n", ["4:9"]),
    "baseline: syntax": ("base.json", '{"format":\n }', ["2:2"]),
    "baseline: not UTF-8": ("base.json", b'{"a":\n "\xff"}', ["2:3"]),
    "baseline: digits": ("base.json", f'{{"a":\n {LONG}}}', ["2:2"]),
    "baseline: other": ("base.json", '{\n "format": "actspec-baseline/2"}', ["2:2"]),
    "baseline: shape": ("base.json", f"{SHAPE}{ENTRY % 1},\n 3]}}", ["2:2"]),
    "baseline: figure": ("base.json", f"{SHAPE}{ENTRY % 1},\n {ENTRY % ('1' + '0' * 400)}]}}", ["2:2"]),
    "lock: syntax": ("actspec.lock", '{"format":\n "actspec-lock/1" 3}', ["2:19"]),
    "lock: other": ("actspec.lock", '{\n "format": "actspec-lock/2"}', ["2:2"]),
    "lock: path": ("actspec.lock", LOCK + ' "/a.xml": {"kind": "mjcf", "robots": {}}}}', ["3:2"]),
    "lock: kind": ("actspec.lock", LOCK + ' "a.xml": {"kind": "x", "robots": {}}}}', ["3:2"]),
    "lock: figure": ("actspec.lock", LOCK + ROBOT + '{\n  "j": {"control": "pd",\n "kp": "x"}}}}}}}', ["7:2"]),
    "lock: edited": ("actspec.lock", LOCK + ROBOT + '{\n  "j": {"control": "pd", "hash": ""}}}}}}}', ["6:3"]),
    "lock: hash": ("actspec.lock", LOCK + ROBOT + "{}}}}}}", ["4:18"]),
    "lock: version": (
        "actspec.lock",
        '{"format": "actspec-lock/1", "files": {}, "versions": {"mujoco": "3.1",\n "mujco": "3"}}',
        ["2:2"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name, data, places", REFUSED.values(), ids=REFUSED)
def test_a_refusal_has_its_place(
    name: str,
    data: bytes | str,
    places: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """File, line and column stand before the code, and the sentence has no line."""
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(SOUND)
    Path(name).write_bytes(data if isinstance(data, bytes) else data.encode())
    arguments = {".lock": ["lock", "--check"], ".json": ["audit", "robot.xml", "--baseline", name]}
    settings = name.endswith(".toml")
    named = ["audit", "robot.xml" if settings else name, "--output-format", "concise"]
    named += ["--config", name] if settings else []
    code = main(arguments.get(Path(name).suffix, named))
    captured = capfd.readouterr()
    told = [line for line in (captured.out + captured.err).splitlines() if line.startswith(f"{name}:")]
    assert [line.split(": ")[0] for line in told] == [f"{name}:{place}" for place in places]
    assert not any("fault of actspec" in line or " line " in line for line in told)
    assert code == (1 if name.endswith((".py", ".yaml")) else 2)


TOML = """# a comment = 1
top = 1.5e3
[audit]
select = ["LIM", # "x",
  "a]b", ['n', {z = 1}]]
a.b.c = 1979-05-27T07:32:00.5Z
s = \"\"\"
[no]
k = 1\"\"\"\"
t = '''
x = ''''
[[arr]]
x = 1979-05-27 07:32:00
[[arr]]
y = {p.q = 1, r = [1,
2]}
[arr.sub]
w = {}
[p.q]
"""


def test_toml_has_a_place_for_every_key() -> None:
    """Of a text with each form of TOML, every key and item that its reader gives has a place, where it is written."""
    found = toml_places(TOML)
    assert {*_ways(tomllib.loads(TOML))} == {*found}
    lines = TOML.splitlines()
    for way, (line, column) in found.items():
        if isinstance(way[-1], str):
            assert lines[line - 1][column - 1 :].startswith(way[-1])
    assert (found["audit", "select", 2, 0], found["arr", 1, "y", "r", 1]) == ((5, 11), (16, 1))


def test_json_has_a_place_for_what_is_wanted() -> None:
    """The last of a key that is there twice, as its reader takes it."""
    text = '{"a": 1, "b": [[], {"c\\u0041": [2, 3]}],\n "a": {"d": {}}}'
    wanted: list[Way] = [("a",), ("a", "d"), ("b", 1, "cA"), ("b", 1, "cA", 1), ("b", 2), ("x",)]
    assert json_places(text, wanted) == {
        ("a",): (2, 2),
        ("a", "d"): (2, 8),
        ("b", 1, "cA"): (1, 21),
        ("b", 1, "cA", 1): (1, 36),
    }


def _ways(data: object, way: Way = ()) -> list[Way]:
    """The paths of all keys and items."""
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [one for key, value in inner for one in ((*way, key), *_ways(value, (*way, key)))]
