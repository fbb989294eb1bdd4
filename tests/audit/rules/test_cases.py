"""Every rule of the audit against its case file, `cases/CODE.yaml`.

A case file is a mapping of cases; `pass_*`, `fail_*` and `skip_*` must all be there, `skip_*` unless the rule's
source never yields `Skipped`. The rule alone runs, with all that the engine does.

    shared:                         # texts that several cases use; optional
      leg.xml: |
        <mujoco> ... <actuator>@ACTUATORS@</actuator> ...
    pass_forcerange:
      files:                        # name: content, or a shared text with its @HOLES@ filled (others become "")
        leg.xml: {shared: leg.xml, with: {ACTUATORS: '<motor joint="knee" forcerange="-1 1"/>'}}
    fail_bare_motor:
      why: what is special here     # optional, for readers
      files: {leg.xml: ..., scene.xml: ...}
      audit: [scene.xml]            # files that are named to the audit; default: all but .json, in their order
      versions: {isaaclab: "2.3"}   # as `--target`
      options: {ratio: 0.5}         # of this rule
      expect:                       # every finding, in any order
        - joint: knee               # or joints: [...], one finding each; neither: a finding without a joint
          file: leg.xml             # needed when more than one file is there
          at: '<motor joint="{joint}"'   # text on its line, once in the file; or line: 12
          message: ...              # the whole of it
          value: 1e9                # these and `unit`, `expected`, `help`, `severity`, `confidence` and `fix`
                                    # (safe, unsafe, null) are compared where they are given
          related: ['robot.urdf:4'] # places, in order; compared where given
      fixed: {leg.xml: ...}         # files after all fixes, safe and unsafe, which must leave nothing to fix; a rule
                                    # that offers fixes has at least one such case
    skip_urdf_alone:
      files: {leg.urdf: ...}
      reason: no MJCF among the files    # the whole of it; no finding may be there

The docstring of a rule is tested too: the files of its Example (fences `xml`, `python`, `yaml`, with a file name
behind where one fence is not enough: `python robot_cfg.py`) give at least one finding, and with those of `Use
instead` in their place none. A fence `sh` with `actspec audit ... --target isaaclab==2.3` names versions.
"""

from __future__ import annotations

import math
import pickle
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec.audit.build import case_of
from actspec.audit.engine import judge
from actspec.audit.finding import Safety
from actspec.audit.fix import apply_fixes
from actspec.audit.outcome import Report, Reported
from actspec.audit.pages import FAMILIES, family
from actspec.audit.read import read_file
from actspec.audit.rule import Rule, RuleOver, sections
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings
from actspec.readings.including import without_fragments
from actspec.readings.named import expand
from actspec.readings.versions import Versions

CASES = Path(__file__).parent / "cases"
RULES = {rule.code: rule for rule in all_rules()}
FORMER = {code: rule for rule in RULES.values() for code in rule.aliases}
"""Cases stand under the code that they were written for."""
KINDS = ("pass", "fail", "skip")
COMPARED = ("value", "unit", "expected", "help", "severity", "confidence", "fix", "related")
SUFFIX = {"xml": ".xml", "python": ".py", "yaml": ".yaml"}

KEYS = {
    "pass": {"why", "files", "audit", "versions", "options"},
    "fail": {"why", "files", "audit", "versions", "options", "expect", "fixed"},
    "skip": {"why", "files", "audit", "versions", "options", "reason"},
}
FINDING_KEYS = {"joint", "joints", "file", "at", "line", "message", *COMPARED}


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """YAML in which 1e9 is a number, as in a spec; by libyaml, where it is, ten times as fast."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+$"), list("-+0123456789")
)


def load(path: Path) -> dict[str, Any]:
    """A case file."""
    found: dict[str, Any] = yaml.load(path.read_text(encoding="utf-8"), _Loader)
    return found


def cases() -> list[Any]:
    """Every case of every file."""
    return [
        pytest.param(path.stem, name, id=f"{path.stem}-{name}")
        for path in sorted(CASES.glob("*.yaml"))
        for name in load(path)
        if name != "shared"
    ]


def text_of(content: Any, shared: dict[str, str]) -> str:
    """A file's text, its holes filled."""
    if isinstance(content, str):
        return content
    assert set(content) <= {"shared", "with"}, content
    text = shared[content["shared"]]
    holes = set(re.findall(r"@([A-Z_]+)@", text))
    given = content.get("with", {})
    assert set(given) <= holes, f"{content['shared']} has no hole {set(given) - holes}"
    return re.sub(r"@([A-Z_]+)@", lambda found: str(given.get(found[1], "")), text)


def run(
    rule: type[Rule],
    files: dict[str, str],
    named: list[str] | None = None,
    versions: dict[str, str] | None = None,
    options: dict[str, float] | None = None,
) -> Report:
    """Audit files in the working folder with one rule."""
    for name, text in files.items():
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text, encoding="utf-8")
    settings = Settings(
        select=(rule.code,), versions=Versions(**(versions or {})), options={rule.code: options or {}}
    )
    named = named or [file for file in files if not file.endswith(".json")]
    paths = [file.path for file in expand(named)]
    keep_matrices = any(path.endswith((".py", ".yaml")) for path in paths)
    # In this process, but as they come out of the audit's own: a thousand of those take a minute.
    readings = pickle.loads(pickle.dumps([read_file(path, keep_matrices) for path in paths]))
    case = case_of(without_fragments(readings), settings.versions, settings.options)
    report = judge(case, settings)
    for file in report.case.files:
        assert file.readable or rule.code == "AUD008", f"{file.path}: {file.reason}"
    assert not report.problems, [str(problem) for problem in report.problems]
    return report


def place(entry: dict[str, Any], files: dict[str, str], joint: str) -> tuple[str, int]:
    """File and line of an expected finding."""
    file = entry["file"] if len(files) > 1 else next(iter(files))
    if "at" not in entry:
        return file, entry["line"]
    lines = files[file].splitlines()
    at = entry["at"].replace("{joint}", joint)
    found = [number for number, line in enumerate(lines, 1) if at in line]
    assert len(found) == 1, f"{at!r} is on lines {found} of {file}"
    return file, found[0]


def compared(item: Reported, entry: dict[str, Any]) -> dict[str, Any]:
    """Of a finding, what an expectation speaks of."""
    finding = item.finding
    everything = {
        "value": finding.value,
        "unit": finding.unit,
        "expected": finding.expected,
        "help": finding.help,
        "severity": item.severity.value,
        "confidence": item.confidence.value,
        "fix": finding.fix.safety.value if finding.fix is not None else None,
        "related": [f"{span.path}:{span.line}" for span in finding.related],
    }
    return {key: everything[key] for key in COMPARED if key in entry}


def close(have: dict[str, Any], want: dict[str, Any]) -> bool:
    """Equal, figures to nine digits."""
    return all(
        math.isclose(have[key], value, rel_tol=1e-9)
        if isinstance(value, float) and isinstance(have[key], float)
        else have[key] == value
        for key, value in want.items()
    )


@pytest.mark.slow
@pytest.mark.parametrize("code, name", cases())
def test_case(code: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case gives exactly the findings that it states, or the reason for which the rule cannot look."""
    monkeypatch.chdir(tmp_path)
    data = load(CASES / f"{code}.yaml")
    rule = FORMER.get(code) or RULES[code]
    case, kind = data[name], name.partition("_")[0]
    assert set(case) <= KEYS[kind], f"{name}: unknown keys {set(case) - KEYS[kind]}"
    files = {file: text_of(content, data.get("shared", {})) for file, content in case["files"].items()}
    report = run(rule, files, case.get("audit"), case.get("versions"), case.get("options"))
    found = [item for item in report.findings if item.finding.code == rule.code]
    skipped = [item.reason for item in report.skipped if item.code == rule.code]
    if kind == "skip":
        assert (found, skipped) == ([], [case["reason"]])
        return
    assert not skipped
    wanted = []
    for entry in case.get("expect", []):
        assert set(entry) <= FINDING_KEYS, f"{name}: unknown keys {set(entry) - FINDING_KEYS}"
        for joint in entry.get("joints", [entry.get("joint", "")]):
            wanted.append((*place(entry, files, joint), joint, entry["message"], entry))
    assert bool(wanted) == (kind == "fail")

    def key(item: Reported) -> tuple[str, int, str, str]:
        return item.finding.span.path, item.finding.span.line, item.finding.joint, item.finding.message

    assert sorted(map(key, found)) == sorted(
        (file, line, joint, text) for file, line, joint, text, _ in wanted
    )
    for file, line, joint, message, entry in wanted:
        item = next(item for item in found if key(item) == (file, line, joint, message))
        want = {key: entry[key] for key in COMPARED if key in entry}
        have = compared(item, entry)
        assert close(have, want), (have, want)
    if "fixed" in case:
        fixes = apply_fixes(report.findings, report.case.files, unsafe=True)
        assert not fixes.refused, [str(item) for item in fixes.refused]
        fixed = {file: text_of(content, data.get("shared", {})) for file, content in case["fixed"].items()}
        assert {file.path: file.new.decode() for file in fixes.files} == fixed
        after = run(rule, {**files, **fixed}, case.get("audit"), case.get("versions"), case.get("options"))
        assert not [item for item in after.findings if item.finding.fix is not None]


def _every(code: str) -> dict[str, Any]:
    """All cases of a rule, those of the rules that it took the place of too."""
    codes = dict.fromkeys((code, *RULES[code].aliases))
    files = (CASES / f"{one}.yaml" for one in codes)
    return {name: case for file in files if file.exists() for name, case in load(file).items()}


def test_every_case_file_has_its_rule() -> None:
    """No case file is left over from a rule that has gone."""
    assert {path.stem for path in CASES.glob("*.yaml")} <= set(RULES) | set(FORMER)


@pytest.mark.parametrize("code", RULES)
def test_every_kind_of_case_is_there(code: str) -> None:
    """A rule has cases that pass, fail and are skipped for lack of input; each begins with its kind."""
    kinds = {name.partition("_")[0] for name in _every(code) if name != "shared"}
    # Of a rule over whole files there is always something to judge.
    assert kinds == set(KINDS) - ({"skip"} if not issubclass(RULES[code], RuleOver) else set())


@pytest.mark.parametrize("code", RULES)
def test_fixes_are_shown(code: str) -> None:
    """A rule that offers fixes has a case with what they do, and no other has."""
    assert any("fixed" in case for case in _every(code).values()) == (RULES[code].fix is not None)


def test_codes_and_names() -> None:
    """Codes and names are unique and well formed, and every family has its line in the index."""
    assert len(RULES) == len(all_rules())
    names = [rule.name for rule in RULES.values()]
    assert len(set(names)) == len(names)
    for rule in RULES.values():
        assert re.fullmatch(r"[A-Z]{3}\d{3}", rule.code)
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)+", rule.name), rule.name
        assert family(rule) in FAMILIES
        assert rule.fix is None or isinstance(rule.fix, Safety)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_page(rule: type[Rule]) -> None:
    """A rule's docstring has a title in one sentence and the sections of a page."""
    found = sections(rule)
    assert re.fullmatch(r"[A-Z`].*\.", found[""]), found[""]
    assert all(text.strip() for text in found.values())


FENCE = r'^```(\w+)(?: title="([^"\n]+)")?\n(.*?)^```$'


def fences(text: str) -> tuple[dict[str, str], dict[str, str]]:
    """Files of a section, and the versions that a `sh` fence in it names."""
    files: dict[str, str] = {}
    versions: dict[str, str] = {}
    for language, name, body in re.findall(FENCE, text, re.MULTILINE | re.DOTALL):
        if language == "sh":
            versions |= dict(re.findall(r"--target (\w+)==(\S+)", body))
        else:
            files[name or f"robot{SUFFIX[language]}"] = body
    return files, versions


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_example(rule: type[Rule], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Example gives a finding of the rule; with the files of `Use instead` in their place it gives none."""
    page = sections(rule)
    files, versions = fences(page["Example"])
    better, other = fences(page["Use instead"])
    assert files and better
    for folder, content, count in (("bad", files, True), ("good", files | better, False)):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        report = run(rule, content, None, versions | (other if folder == "good" else {}))
        codes = {item.finding.code for item in report.findings}
        assert (rule.code in codes) == count, folder
        assert rule.code not in {item.code for item in report.skipped}
