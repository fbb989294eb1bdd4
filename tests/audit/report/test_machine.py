"""JSON, SARIF, GitHub and JUnit: the form that their readers ask for, and nothing that breaks out of it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from lxml import etree

from actspec.audit.outcome import Report
from actspec.diagnostics import Severity
from actspec.readings.ledger import CONTROLS, LedgerRow
from actspec.report import ReportOptions, render
from actspec.report.ledger import COLUMNS, JSON_FIELDS, JSON_FLAGS
from actspec.report.sarif import location
from actspec.report.terminal import json_number as number
from tests.audit.report.reporting import EVIL, report
from tests.schemas import fits, validator

# --- the forms -----------------------------------------------------------------------------------


def _object(required: dict[str, Any], **optional: Any) -> dict[str, Any]:
    return {
        "type": "object",
        "additionalProperties": False,
        "required": list(required),
        "properties": {**required, **optional},
    }


def _list(items: Any) -> dict[str, Any]:
    return {"type": "array", "items": items}


_TEXT = {"type": "string", "minLength": 1}
_COUNT = {"type": "integer", "minimum": 1}
_LEVEL = {"enum": ["none", "note", "warning", "error"]}
_MESSAGE = _object({"text": _TEXT}, markdown=_TEXT)
_BAG = {"type": "object"}
_ARTIFACT = _object({"uri": {**_TEXT, "pattern": r"^([A-Za-z0-9/_.~:-]|%[0-9A-F]{2})+$"}}, uriBaseId=_TEXT)
_REGION = {
    **_object(
        {},
        startLine=_COUNT,
        startColumn=_COUNT,
        endColumn=_COUNT,
        byteOffset={"minimum": 0},
        byteLength={"minimum": 0},
    ),
    "minProperties": 1,
}
_LOCATION = _object(
    {"physicalLocation": _object({"artifactLocation": _ARTIFACT}, region=_REGION)},
    id={"type": "integer", "minimum": 0},
    logicalLocations=_list(_object({"name": _TEXT, "kind": _TEXT})),
)
_FIX = _object(
    {
        "description": _MESSAGE,
        "artifactChanges": _list(
            _object(
                {
                    "artifactLocation": _ARTIFACT,
                    "replacements": _list(
                        _object(
                            {
                                "deletedRegion": _REGION,
                                "insertedContent": _object({"text": {"type": "string"}}),
                            }
                        )
                    ),
                }
            )
        ),
    }
)
_RESULT = _object(
    {
        "ruleId": _TEXT,
        "ruleIndex": {"type": "integer", "minimum": 0},
        "level": _LEVEL,
        "message": _MESSAGE,
        "locations": {**_list(_LOCATION), "minItems": 1},
        "partialFingerprints": {"type": "object", "additionalProperties": _TEXT},
    },
    relatedLocations=_list(_LOCATION),
    fixes=_list(_FIX),
    properties=_BAG,
)
_RULE = _object(
    {
        "id": _TEXT,
        "name": {**_TEXT, "pattern": "^[A-Z][A-Za-z0-9]+$"},
        "shortDescription": _MESSAGE,
        "fullDescription": _MESSAGE,
        "help": _MESSAGE,
        "defaultConfiguration": _object({"level": _LEVEL}),
        "properties": _BAG,
    }
)
_NOTIFICATION = _object(
    {"level": _LEVEL, "message": _MESSAGE, "descriptor": _object({"id": _TEXT})}, locations=_list(_LOCATION)
)
SARIF = _object(
    {
        "$schema": _TEXT,
        "version": {"const": "2.1.0"},
        "runs": _list(
            _object(
                {
                    "tool": _object(
                        {"driver": _object({"name": _TEXT, "semanticVersion": _TEXT, "rules": _list(_RULE)})}
                    ),
                    "columnKind": {"enum": ["utf16CodeUnits", "unicodeCodePoints"]},
                    "originalUriBaseIds": {
                        "type": "object",
                        "additionalProperties": _object({"description": _MESSAGE}),
                    },
                    "invocations": _list(
                        _object(
                            {
                                "executionSuccessful": {"type": "boolean"},
                                "toolExecutionNotifications": _list(_NOTIFICATION),
                            }
                        )
                    ),
                    "results": _list(_RESULT),
                }
            )
        ),
    }
)
"""What of SARIF 2.1.0 is used here: names and types as the standard has them. The standard's own schema is in no
installable package; what is written was held to it once."""

JUNIT = """
<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema">
  <xs:attributeGroup name="counts">
    <xs:attribute name="name" type="xs:string" use="required"/>
    <xs:attribute name="tests" type="xs:nonNegativeInteger" use="required"/>
    <xs:attribute name="failures" type="xs:nonNegativeInteger" use="required"/>
    <xs:attribute name="errors" type="xs:nonNegativeInteger" use="required"/>
    <xs:attribute name="skipped" type="xs:nonNegativeInteger" use="required"/>
  </xs:attributeGroup>
  <xs:complexType name="result" mixed="true">
    <xs:attribute name="type" type="xs:string"/>
    <xs:attribute name="message" type="xs:string" use="required"/>
  </xs:complexType>
  <xs:element name="testsuites"><xs:complexType>
    <xs:sequence><xs:element name="testsuite" maxOccurs="unbounded"><xs:complexType>
      <xs:sequence><xs:element name="testcase" minOccurs="1" maxOccurs="unbounded"><xs:complexType>
        <xs:choice minOccurs="0">
          <xs:element name="failure" type="result"/>
          <xs:element name="error" type="result"/>
          <xs:element name="skipped" type="result"/>
          <xs:element name="system-out" type="xs:string"/>
        </xs:choice>
        <xs:attribute name="name" type="xs:string" use="required"/>
        <xs:attribute name="classname" type="xs:string" use="required"/>
        <xs:attribute name="file" type="xs:string"/>
        <xs:attribute name="line" type="xs:positiveInteger"/>
      </xs:complexType></xs:element></xs:sequence>
      <xs:attributeGroup ref="counts"/>
    </xs:complexType></xs:element></xs:sequence>
    <xs:attributeGroup ref="counts"/>
  </xs:complexType></xs:element>
</xs:schema>
"""
"""The part of JUnit's XML that build servers read."""


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Report:
    """The report, made in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return report()


# --- json ----------------------------------------------------------------------------------------


def test_json(made: Report) -> None:
    """It has the form of its schema, one finding a joint, null for unknown, Infinity for no limit."""
    data = json.loads(render(made, "json", ReportOptions()), parse_constant=pytest.fail)
    fits("report", data)
    assert list(data) == ["format", "files", "ledger", "findings", "shown_as", "skipped", "diagnostics"]
    assert data["findings"][0] == {
        "code": "LIM901",
        "name": "first-rule",
        "severity": "error",
        "confidence": "high",
        "file": "a.xml",
        "line": 2,
        "column": 22,
        "joint": "hip",
        "message": "no limit, got 0 N*m",
        "value": "Infinity",
        "unit": "N*m",
        "expected": 33.5,
        "help": "add one",
        "fix": "unsafe",
        "explained_by": None,
    }
    assert [item["joint"] for item in data["findings"]] == ["hip", "ankle", "knee", "hip", None, None]
    assert [(item["line"], item["column"]) for item in data["findings"][3:]] == [
        (2, None),
        (1, 1),
        (None, None),
    ]
    # Half a surrogate pair is no text to most readers of JSON.
    assert data["findings"][5]["message"] == f"bad {EVIL}".replace("\ud800", "\\ud800")
    assert [file["readable"] for file in data["files"]] == [True, True, False, False]
    assert [file["kind"] for file in data["files"]] == ["mjcf", "urdf", None, None]
    assert [row["effort_limit"] for row in data["ledger"]] == [50, 50, "Infinity", None, 35, 50.1, None]
    assert [data["ledger"][0][name] for name in ("kd_clamped", "kd_implicit")] == [True, None]
    assert data["skipped"] == [{"code": "NET901", "reason": "no network among the files"}]
    assert [item["code"] for item in data["diagnostics"]] == ["ROBOT113", "AUD016"]


@pytest.mark.parametrize(
    "value, written",
    [(None, None), (math.nan, None), (math.inf, "Infinity"), (-math.inf, "-Infinity"), (0.1, 0.1)],
    ids=["unknown", "nan", "inf", "minus inf", "number"],
)
def test_figures_in_json(value: float | None, written: object) -> None:
    """JSON has neither NaN nor infinity."""
    assert number(value) == written


def test_the_schema_knows_every_figure() -> None:
    """Ledger entries, the schema and the table's columns speak of the same fields."""
    entry = validator("report").schema["properties"]["ledger"]["items"]["properties"]
    assert list(entry) == [
        "file",
        "line",
        "joint",
        "actuator",
        "control",
        "drives",
        *JSON_FIELDS,
        *JSON_FLAGS,
    ]
    assert entry["control"]["enum"] == list(CONTROLS)
    assert {column.name for column in COLUMNS} <= set(LedgerRow.__dataclass_fields__)


# --- sarif ---------------------------------------------------------------------------------------


def test_sarif(made: Report) -> None:
    """It has SARIF's form; findings of one place are one result; columns count UTF-16 code units."""
    data = json.loads(render(made, "sarif", ReportOptions()))
    jsonschema.validate(data, SARIF)
    (run,) = data["runs"]
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == ["LIM901", "SRC901", "NET901", "AUD008"]
    results = run["results"]
    assert [(item["ruleId"], item["ruleIndex"], item["level"]) for item in results] == [
        ("LIM901", 0, "error"),
        ("LIM901", 0, "error"),
        ("SRC901", 1, "warning"),
        ("AUD008", 3, "error"),
        ("SRC901", 1, "note"),
    ]
    assert [item["message"]["text"] for item in results[:2]] == [
        "hip: no limit, got 0 N*m. Add one.",
        "ankle, knee: no limit, got 0 N*m. Add one.",
    ]
    # 21 characters stand before, one of them two units long; the line has 41 characters.
    region = results[0]["locations"][0]["physicalLocation"]["region"]
    assert region == {"startLine": 2, "startColumn": 23, "endColumn": 43}
    assert len({json.dumps(item["partialFingerprints"]) for item in results}) == 5
    related = results[2]["relatedLocations"][0]["physicalLocation"]
    assert related == {
        "artifactLocation": {"uri": "a.xml", "uriBaseId": "%SRCROOT%"},
        "region": {"startLine": 3, "startColumn": 3, "endColumn": 24},
    }
    assert results[4]["locations"] == [
        {"physicalLocation": {"artifactLocation": {"uri": "we%20ird%25.xml", "uriBaseId": "%SRCROOT%"}}}
    ]
    assert r"\[a\](b)" in results[4]["message"]["text"]
    change = results[0]["fixes"][0]["artifactChanges"][0]["replacements"][0]
    assert change == {"deletedRegion": {"byteOffset": 10, "byteLength": 2}, "insertedContent": {"text": "xx"}}
    (invocation,) = run["invocations"]
    assert invocation["executionSuccessful"] is False
    notes = [(item["descriptor"]["id"], item["level"]) for item in invocation["toolExecutionNotifications"]]
    assert notes == [("ROBOT113", "note"), ("AUD016", "error")]


def test_sarif_help_is_a_sentence() -> None:
    """Help that asks keeps its question mark, with nothing behind it."""
    from actspec.audit.engine import judge
    from actspec.audit.settings import Settings
    from tests.audit.making import case_of, finding, rule_of

    rule = rule_of("LIM901", "first-rule", finding("LIM901", help="did you mean 'kp'?"))
    data = json.loads(render(judge(case_of(), Settings(), (rule,)), "sarif", ReportOptions()))
    assert data["runs"][0]["results"][0]["message"]["text"] == "wrong. Did you mean 'kp'?"


def test_sarif_fingerprints_do_not_know_lines(made: Report, monkeypatch: pytest.MonkeyPatch) -> None:
    """A finding keeps its fingerprint when it moves, and two equal ones of a file differ."""
    from actspec.audit.engine import judge
    from actspec.audit.settings import Settings
    from tests.audit.making import case_of, finding, rule_of

    def prints(*lines: int) -> list[str]:
        rule = rule_of(
            "LIM901", "first-rule", *[finding("LIM901", line=line, joint="knee") for line in lines]
        )
        data = json.loads(render(judge(case_of(), Settings(), (rule,)), "sarif", ReportOptions()))
        return [item["partialFingerprints"]["actspecFinding/v2"] for item in data["runs"][0]["results"]]

    assert prints(3) == prints(30)
    assert len(set(prints(3, 4))) == 2


@pytest.mark.parametrize(
    "path, uri, base",
    [
        ("a b.xml", "a%20b.xml", "%SRCROOT%"),
        ("./x/../a.xml", "a.xml", "%SRCROOT%"),
        ("ü#?.xml", "%C3%BC%23%3F.xml", "%SRCROOT%"),
        ("a:b.xml", "a%3Ab.xml", "%SRCROOT%"),
        ("/nowhere/a b.xml", "file:///nowhere/a%20b.xml", None),
    ],
    ids=["space", "dots", "reserved", "colon", "outside"],
)
def test_sarif_paths(
    path: str, uri: str, base: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below the working folder a relative address, elsewhere an absolute one, both percent-encoded."""
    monkeypatch.chdir(tmp_path)
    found = location(path)
    assert (found["uri"], found.get("uriBaseId")) == (uri, base)


@pytest.mark.parametrize("output_format", ["json", "sarif", "github", "junit", "markdown", "html"])
def test_notes_are_left_out_where_that_is_asked_for(output_format: str, made: Report) -> None:
    """Of the four rules and severities the note is the one with the evil name."""
    assert "alert(1)" in render(made, output_format, ReportOptions()).split("Ledger: what")[0]
    left = render(
        replace(made, case=replace(made.case, rows=())), output_format, ReportOptions(least=Severity.WARNING)
    )
    assert "alert(1)" not in left
    assert "50 here, 35 there" in left


# --- github --------------------------------------------------------------------------------------


def test_github(made: Report) -> None:
    """One annotation a fault; what a name brings along cannot end a property or begin a command."""
    assert render(made, "github", ReportOptions()).splitlines() == [
        "::error title=LIM901 first-rule,file=a.xml,line=2,col=22::hip, ankle, knee: no limit, got 0 N*m"
        "%0Ahelp: add one",
        "::error title=AUD008 unreadable-file,file=secret.txt,line=1,col=1::the file cannot be read: this is not XML "
        "(ROBOT004)",
        "::warning title=SRC901 second-rule,file=b.urdf,line=2::hip: 50 here, 35 there",
        "::notice title=SRC901 second-rule,file=we ird%25.xml::bad <script>alert(1)</script>|\"'&\\x07\\n"
        "[a](b)@me #1 %2541,:\\ud800",
        "::error title=AUD016,file=gone.xml::there is no such file",
    ]


def test_github_properties(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A colon or comma in a file's name is no separator, and no control character reaches a log."""
    from actspec.audit.engine import judge
    from actspec.audit.settings import Settings
    from tests.audit.making import case_of, finding, rule_of

    monkeypatch.chdir(tmp_path)
    rule = rule_of(
        "LIM901", "first-rule", finding("LIM901", "a:b,c\r\x1b[31m.xml", message="100 %\r\n::error::x")
    )
    text = render(judge(case_of(), Settings(), (rule,)), "github", ReportOptions())
    assert text == (
        "::warning title=LIM901 first-rule,file=a%3Ab%2Cc%0D\\x1b[31m.xml,line=1,col=1::100 %25\\r\\n::error::x\n"
    )


# --- junit ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "fail_on, failures", [(Severity.ERROR, 2), (Severity.INFO, 4), (None, 0)], ids=["error", "info", "never"]
)
def test_junit(fail_on: Severity | None, failures: int, made: Report) -> None:
    """It has JUnit's form; what counts as a failure is what fails the run; files that are not there are errors."""
    text = render(made, "junit", ReportOptions(fail_on=fail_on, chosen=True))
    root = etree.fromstring(text.encode("utf-8"))
    etree.XMLSchema(etree.fromstring(JUNIT)).assertValid(root)
    counts = [root.get(key) for key in ("tests", "failures", "errors", "skipped")]
    assert counts == ["6", str(failures), "1", "1"]
    assert [suite.get("name") for suite in root] == [
        "a.xml",
        "b.urdf",
        "secret.txt",
        "gone.xml",
        "we ird%.xml",
        "rules",
    ]
    assert [case.get("name") for case in root.iter("testcase")] == [
        "LIM901 first-rule: hip and 2 more",
        "SRC901 second-rule: hip",
        "AUD008 unreadable-file: file",
        "AUD016",
        "SRC901 second-rule: file",
        "NET901",
    ]


def test_junit_tells_what_a_rule_lacks_only_to_whom_asked_for_it(made: Report) -> None:
    """With all rules most lack something in every run, and a server would show them as skipped tests for ever."""
    root = etree.fromstring(render(made, "junit", ReportOptions()).encode("utf-8"))
    assert (root.get("skipped"), [suite.get("name") for suite in root][-1]) == ("0", "we ird%.xml")


def test_junit_of_a_clean_file(tmp_path: Path) -> None:
    """A file without findings is a test that passes: build servers refuse a suite without any."""
    from actspec.audit.engine import judge
    from actspec.audit.settings import Settings
    from tests.audit.making import case_of

    root = etree.fromstring(
        render(judge(case_of({"a.xml": b"<a/>"}), Settings(), ()), "junit", ReportOptions()).encode()
    )
    etree.XMLSchema(etree.fromstring(JUNIT)).assertValid(root)
    assert [case.get("name") for case in root.iter("testcase")] == ["no findings"]
