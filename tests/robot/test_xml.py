"""Parsing of MJCF and URDF text: offsets, includes as MuJoCo has them, refusals."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.parsers import expat

import mujoco
import pytest
from hypothesis import given
from hypothesis import strategies as st

from actspec.diagnostics import Collector, RobotError, Severity, Span
from actspec.robot import xml
from actspec.robot.view import ModelFile
from actspec.robot.xml import open_document, parse_document
from actspec.robot.xml_tree import Element, XmlDocument, report_behind

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS") or Path(__file__).parents[2].parent / "shared" / "corpus")
MODELS = sorted(p for p in CORPUS.rglob("*") if p.suffix in (".xml", ".urdf"))
MODEL_IDS = [p.relative_to(CORPUS).as_posix() for p in MODELS]
BROKEN = "unitree_mujoco/unitree_robots/g1/scene.xml"
"""Has `</mujoco>` twice; MuJoCo reads it, expat and lxml do not."""


def parsed(data: bytes | str) -> XmlDocument:
    """A document of one file."""
    if isinstance(data, str):
        data = data.encode()
    return parse_document((ModelFile("r.xml", "", data),))


def refused(data: bytes | str) -> str:
    """What is said about a document of one file."""
    with pytest.raises(RobotError) as caught:
        parsed(data)
    return str(caught.value)


def written(folder: Path, files: Mapping[str, str | bytes]) -> str:
    """Write files; the path of m/main.xml among them."""
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.replace("$D", str(folder)).encode())
    return str(folder / "m" / "main.xml")


TRICKY = (
    b"\xef\xbb\xbf<?xml version='1.0'?>\r\n"
    b"<!-- <joint name='no'/> -->\r\n"
    b"<mujoco\r\n"
    b"  model = 'a>b/'><?pi <joint/> ?>\r\n"
    b"  <![CDATA[<joint/>]]>\r\n"
    b'  <!-- \xc3\xa9 --><joint name="k&amp;&#10;n" range="0\r\n1" />\r\n'
    b"  <option></option ><x:y/>\r\n"
    b"</mujoco>\r\n"
)


def test_offsets_point_at_the_authors_bytes() -> None:
    """Every offset of a file with BOM, CRLF, comments, CDATA and quotes of both kinds is its byte."""
    document = parsed(TRICKY)
    root = document.root
    assert [e.tag for e in document.walk()] == ["mujoco", "joint", "option", "x:y"]
    model = root.attributes["model"]
    assert TRICKY[model.start : model.end] == b"model = 'a>b/'"
    assert TRICKY[model.value_start : model.value_end] == b"a>b/"
    assert TRICKY[root.start : root.open_end] == b"<mujoco\r\n  model = 'a>b/'>"
    assert TRICKY[root.start : root.end].endswith(b"</mujoco>")
    joint, option, last = root.children
    assert TRICKY[joint.start : joint.end] == b'<joint name="k&amp;&#10;n" range="0\r\n1" />'
    assert (joint.self_closing, joint.open_end) == (True, joint.end)
    assert list(joint.attributes) == ["name", "range"]
    assert joint.get("name") == "k&\nn"  # &#10; is a line feed
    assert joint.get("range") == "0 1"  # CR LF in a value is one line end, then one space
    assert (joint.get("x"), joint.get("x", "y")) == (None, "y")
    assert TRICKY[option.start : option.open_end] == b"<option>"
    assert TRICKY[option.start : option.end] == b"<option></option >"
    assert not option.self_closing and last.self_closing


def test_lines_and_columns_count_from_one_in_characters() -> None:
    """A column counts characters, not bytes: the comment before the joint has one of two bytes."""
    document = parsed(TRICKY)
    joint = document.root.children[0]
    # "  <!-- é -->" is 12 characters, 13 bytes.
    assert document.span(joint) == Span("r.xml", 6, 13)
    assert document.span(document.root) == Span("r.xml", 3, 1)


ATTRIBUTES = st.lists(
    st.sampled_from(
        [
            " a='1\"2'",
            ' b="&lt;&#x41;&#66;\t\r\n\r;"',
            ' c = "\'>/"',
            " \u00e9='\u20ac&quot;'",
            '\n d="\u0085\u00a0/"',
            "\r\n",
            "\re=''",
        ]
    ),
    max_size=4,
    unique=True,
).map("".join)
BETWEEN = st.sampled_from(
    [
        "",
        "\n",
        "\r",
        "\r\n",
        "<!-- <b> > ' -->",
        "<!-- \u00e9\n-->",
        "<?p <b>\n?>",
        "<![CDATA[<b>]]>",
        "&amp;>\u00e9\u0085",
    ]
)
TAGS = st.sampled_from(["a", "b:c", "\u00e9"])
INSIDE = st.recursive(
    st.builds("{}<{}{}/>{}".format, BETWEEN, TAGS, ATTRIBUTES, BETWEEN),
    lambda inner: st.builds(
        lambda tag, attributes, parts, blank: f"<{tag}{attributes}>{''.join(parts)}</{tag}{blank}>",
        TAGS,
        ATTRIBUTES,
        st.lists(st.one_of(inner, BETWEEN), max_size=3),
        st.sampled_from(["", " \n"]),
    ),
    max_leaves=6,
)


@given(INSIDE, st.sampled_from(["", "\ufeff", "\ufeff<!-- x --> ", "<?xml version='1.0'?>"]))
def test_elements_are_those_of_expat(inside: str, head: str) -> None:
    """Tags, values, places and children are what expat's own calls say."""
    data = f"{head}<r>{inside}</r>".encode()
    expected = []
    ends: list[str] = []
    parser = expat.ParserCreate("utf-8")

    def start(tag: str, attributes: dict[str, str]) -> None:
        # A byte order mark is no character of the first line.
        column = parser.CurrentColumnNumber + (parser.CurrentLineNumber > 1 or not head.startswith("\ufeff"))
        place = parser.CurrentLineNumber, column
        expected.append((tag, list(attributes.items()), parser.CurrentByteIndex, *place))

    parser.StartElementHandler = start
    parser.EndElementHandler = ends.append
    parser.Parse(data, True)
    elements = list(parsed(data).walk())
    assert [(e.tag, list(e.values.items()), e.start, e.line, e.column) for e in elements] == expected
    # Ends come in the order in which elements close: by their end, the inner one of two before the outer.
    assert [e.tag for e in sorted(elements, key=lambda e: (e.end, -e.start))] == ends


def test_walk_and_sections() -> None:
    """`walk` is depth first; `sections` takes children of the root only."""
    document = parsed("<a><b><c/><b/></b><c/><b/></a>")
    assert [e.tag for e in document.walk()] == ["a", "b", "c", "b", "c", "b"]
    assert [e.start for e in document.walk("c", "a")] == [0, 6, 18]
    assert [e.start for e in document.sections("b")] == [3, 22]


@pytest.mark.parametrize(
    ("data", "text"),
    [
        pytest.param('<a x="1" x="2"/>', "1:10: ROBOT004: attribute 'x' appears twice", id="twice"),
        pytest.param("<a>\n<!-- a -- b </a>", "2:10: ROBOT004: a comment that is never closed", id="dashes"),
        pytest.param(
            "<a>\n<b></a>", "2:6: ROBOT004: </a> stands where <b> (line 2) is to be closed", id="tags"
        ),
        pytest.param("<a>\n<b>", "2:4: ROBOT004: the file ends before <b> (line 2) is closed", id="open"),
        pytest.param(
            "<a/>\n</b", "2:2: ROBOT004: a closing tag whose element is closed already", id="closed"
        ),
        pytest.param(
            "<a/><a>",
            "1:5: ROBOT004: text or an element after the end of the root element",
            id="second root",
        ),
        pytest.param('<a x="a<b"/>', "1:8: ROBOT004: '<' inside an attribute value", id="less in value"),
        pytest.param(
            '<a><b c="\n>\n</a>',
            "3:1: ROBOT004: '<' inside an attribute value that begins in line 1",
            id="no quote",
        ),
        pytest.param('<a x="1" <b/>', "1:10: ROBOT004: a tag begins inside another tag", id="tag in tag"),
        pytest.param('<a x="a & b"/>', "1:10: ROBOT004: a bare '&'", id="ampersand"),
        pytest.param("<a>1 < 2</a>", "1:7: ROBOT004: a '<' that does not begin a tag", id="bare less"),
        pytest.param(
            '<a x="&nbsp;"/>', "1:1: ROBOT004: a reference to an entity that XML does not know", id="entity"
        ),
        pytest.param(
            '<a b="c<d"/><a x="1"y="2"/>', "1:8: ROBOT004: '<' inside an attribute value", id="space later"
        ),
        pytest.param('<a x="1"y="2<"/>', "1:9: ROBOT004: no space between two attributes", id="space"),
        pytest.param(
            '<a x="1"y="2"/>\n<b/>c',
            "2:1: ROBOT004: text or an element after the end of the root element",
            id="behind a space that was added",
        ),
        pytest.param("<a x=1/>", "1:6: ROBOT004: an attribute value without quotes", id="unquoted"),
        pytest.param("<a x/>", "1:5: ROBOT004: an attribute without a value", id="no value"),
        pytest.param("<a><!--\1--></a>", "1:8: ROBOT004: a control character, 0x01", id="control"),
        pytest.param("<a>\0</a>", "1:4: ROBOT004: a control character, 0x00", id="nul"),
        pytest.param("hello", "1:1: ROBOT004: this is not XML", id="text"),
        pytest.param("# old \n", "1:1: ROBOT004: this is not XML", id="a mark that XML allows nowhere"),
        pytest.param("\n  # old\n", "2:3: ROBOT004: this is not XML", id="behind white space"),
        pytest.param("# old\n<a b c/>", "2:6: ROBOT004: an attribute without a value", id="before a tag"),
        pytest.param(
            "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 130\n",
            "1:1: ROBOT004: this is a pointer of Git LFS, and not the file itself",
            id="pointer",
        ),
        pytest.param("", "1:1: ROBOT004: the file has no XML element", id="empty"),
        pytest.param(
            "<a", "1:1: ROBOT004: the file ends inside a tag or comment that starts here", id="half"
        ),
        pytest.param("<a><![CDATA[", "1:13: ROBOT004: the file ends inside a CDATA section", id="cdata"),
        pytest.param(
            "<a>&#0;</a>",
            "1:4: ROBOT004: a reference to a character that XML does not allow",
            id="character reference",
        ),
        pytest.param(
            '<!-- -->\n<?xml version="1.0"?><a/>',
            "2:1: ROBOT004: a malformed XML declaration, or one that is not the first thing in the file",
            id="late declaration",
        ),
        pytest.param('<a "1"/>', "1:4: ROBOT004: not well-formed XML: '\"' cannot stand here", id="other"),
        pytest.param(
            '<!--\n-->\n<!DOCTYPE a [<!ENTITY b "b">]><a x="&b;"/>',
            "3:1: ROBOT005: the file has a DOCTYPE, which can define entities and name other files",
            id="doctype",
        ),
        *(
            pytest.param(
                f"<!DOCTYPE a {more}><a/>",
                "1:1: ROBOT005: the file has a DOCTYPE, which can define entities and name other files",
                id=f"doctype {more}",
            )
            for more in (
                'SYSTEM "a.dtd"',
                "SYSTEM ''",
                'PUBLIC "a" "a.dtd"',
                "[]",
                "[ ]",
                "SYSTEM 'a' []",
                "[%a;]",
            )
        ),
        pytest.param(
            "<!DOCTYPE a><a x='1'>&b;</a>",
            "1:22: ROBOT004: a reference to an entity that XML does not know",
            id="entity behind a plain doctype",
        ),
        pytest.param(
            b"<a>\n<!-- \xe9 --></a>", "2:6: ROBOT003: the file is not UTF-8: byte 0xe9", id="latin 1"
        ),
        pytest.param(
            "<?xml version='1.0' encoding='ISO-8859-1'?>\n<a x='é'/>",
            "2:7: ROBOT003: the file declares encoding 'ISO-8859-1' and has a character that is not ASCII",
            id="declared latin 1",
        ),
        pytest.param(
            "<?xml version='1.0' encoding='ISO-8859-1'?>\n<!-- é --><a x='é'/>".encode("latin-1"),
            "2:17: ROBOT003: the file declares encoding 'ISO-8859-1' and has a character that is not ASCII",
            id="latin 1 in a value",
        ),
        pytest.param(
            "<?xml version='1.0' encoding='ISO-8859-1'?><a x='>é'/>".encode("latin-1"),
            "1:51: ROBOT003: the file declares encoding 'ISO-8859-1' and has a character that is not ASCII",
            id="latin 1 behind a bracket in a value",
        ),
        pytest.param(
            b"<?xml version='1.0' encoding='utf-16'?><!-- \xc3\xa9 --><a/>",
            "1:45: ROBOT003: the file declares encoding 'utf-16' and has a character that is not ASCII",
            id="no encoding of single bytes",
        ),
        pytest.param("<a/>".encode("utf-16"), "1: ROBOT003: the file is UTF-16 or UTF-32", id="utf-16"),
        pytest.param("<a/>".encode("utf-16-be"), "1: ROBOT003: the file is UTF-16 or UTF-32", id="no mark"),
        pytest.param(
            "<a>" * 201 + "</a>" * 201,
            "1:601: ROBOT002: more than 200 elements inside one another",
            id="deep",
        ),
    ],
)
def test_what_is_refused(data: bytes | str, text: str) -> None:
    """Each refusal names the place and says in plain words what is wrong."""
    assert refused(data).split("\n")[0] == f"r.xml:{text}"


@pytest.mark.parametrize(
    "data",
    [
        pytest.param('<a x="a & b"/>', id="ampersand"),
        pytest.param('<a x="a<b"/>', id="less"),
        pytest.param(b"<a x='\xe9'/>", id="latin 1"),
    ],
)
def test_help_for_what_mujoco_reads(data: bytes | str) -> None:
    """Where MuJoCo reads what expat refuses, the help says so."""
    assert "MuJoCo reads it as it is, other readers of XML do not" in refused(data)


@pytest.mark.parametrize(
    ("row", "message", "help"),
    [
        ('<geom size=".1/>', "an attribute value that begins in line 3", "add the missing quote there"),
        ("<geom size='.1\"/>", "an attribute value that begins in line 3", "add the missing quote there"),
        ('<geom size=".1/><geom name="a"/>', "an attribute value that begins in line 3", "quote there"),
        ('<geom name="a size=".1"/>', "no space between two attributes", "or add the missing quote before"),
    ],
)
def test_a_missing_quote(row: str, message: str, help: str) -> None:
    """MuJoCo refuses the file, too, and the place is where the quote has to stand."""
    text = f"<mujoco>\n<worldbody>\n{row}\n</worldbody>\n</mujoco>"
    with pytest.raises(ValueError, match="XML_ERROR_PARSING"):
        mujoco.MjModel.from_xml_string(text)
    assert message in refused(text) and help in refused(text) and "MuJoCo reads" not in refused(text)


@pytest.mark.parametrize(
    ("before", "reads"),
    [
        ("C:\\a path ", True),
        ("a\nb\n", True),
        ('x<?xml version="1.0"?>', False),
        ("x<!DOCTYPE mujoco>", True),
        ("x<!DOCTYPE mujoco SYSTEM 'a.dtd'>", False),
    ],
)
def test_text_before_the_root(before: str, reads: bool) -> None:
    """MuJoCo passes over it; what follows has its place in the file. A DOCTYPE that names a file is refused here."""
    text = f"{before}<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
    if "SYSTEM" not in before:
        try:
            assert mujoco.MjModel.from_xml_string(text).ngeom == 1
        except ValueError:
            assert not reads
    if reads:
        assert parsed(text).root.start == len(before)
    else:
        assert refused(text)


def test_a_doctype_that_defines_nothing() -> None:
    """It names no file either, and is read over, as MuJoCo does; the second of two is no XML."""
    text = '<?xml version="1.0"?>\n<!DOCTYPE xml>\n<mujoco><worldbody><geom size="1"/></worldbody></mujoco>'
    assert mujoco.MjModel.from_xml_string(text).ngeom == 1
    assert [element.tag for element in parsed(text).walk()] == ["mujoco", "worldbody", "geom"]
    assert refused('<!DOCTYPE a><!DOCTYPE a [<!ENTITY b "b">]><a>&b;</a>').startswith("r.xml:1:13: ROBOT004")


@pytest.mark.parametrize("before", ["\n", " ", "<!-- licence -->\n", "<!-- a -->"])
def test_a_late_declaration(before: str, tmp_path: Path) -> None:
    """It is read where the installed MuJoCo reads it: behind white space, not behind a comment."""
    text = f'{before}<?xml version="1.0"?><mujoco><worldbody><geom size="1"/></worldbody></mujoco>'
    path = tmp_path / "m.xml"
    path.write_text(text)
    try:
        reads = mujoco.MjModel.from_xml_path(str(path)) is not None
    except ValueError:
        reads = False
    assert reads is (not before.strip())
    if reads:
        # Behind `before` and the 21 bytes of the declaration.
        assert parsed(text).root.start == len(before) + 21
    else:
        assert "ROBOT004: a malformed XML declaration" in refused(text)


@pytest.mark.parametrize(
    ("tag", "joints"),
    [
        (r"<!-\- a comment, almost -\->", 1),
        ("<!x y='1'>", 1),
        ("<!x <joint name='b'/> >", 1),
        ("<!x ><joint name='b'/>", 2),
    ],
)
def test_a_tag_that_is_nothing(tag: str, joints: int) -> None:
    """MuJoCo reads `<!` as nothing up to the first `>`; what follows has its place in the file."""
    text = f"<mujoco>\n<worldbody><body>{tag}\n<joint name='a'/><geom size='1'/></body></worldbody></mujoco>"
    assert mujoco.MjModel.from_xml_string(text).njnt == joints
    found = [
        element
        for body in parsed(text).root.children[0].children
        for element in body.children
        if element.tag == "joint"
    ]
    assert len(found) == joints
    assert text[found[-1].start :].startswith("<joint name='a'/>")


@pytest.mark.parametrize(
    ("tail", "read"),
    [
        ("\n</mujoco>", True),
        ("</mujoco> </a>\n", True),
        ("\n<mujoco><option timestep='1'/></mujoco>\n", True),
        ("<!-- a --><a b='1'><c>text</c></a><d/>", True),
        ("\ntext", False),
        ("<a/>text", False),
        ("<a>", False),
        ("<a></b>", False),
        ("<?xml version='1.0'?>", False),
        ("<a/><?a?>", False),
        ("<!DOCTYPE a [<!ENTITY b 'b'>]>", False),
        ("<a>&b;</a>", False),
        ("</r><r>", True),
        ("\n<sensor/></mujoco>\n<actuator><", True),
        ("\n</mujoco>\n<actuator/>", True),
        ("\n</worldbody><!-- <joint/> --></mujoco>", True),
    ],
)
def test_what_is_behind_the_root(tail: str, read: bool) -> None:
    """MuJoCo takes nothing from it; it is reported, and what MuJoCo refuses is refused."""
    model = "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
    text = model + tail
    if not read:
        assert refused(text)
        return
    assert mujoco.MjModel.from_xml_string(text).opt.timestep == 0.002
    document, said = parsed(text), Collector()
    assert [element.tag for element in document.walk()] == ["mujoco", "worldbody", "geom"]
    report_behind(document, said)
    line = 2 if tail.startswith("\n") else 1
    behind = tail.removeprefix("<!-- a -->").lstrip()
    at = text.index(behind, len(model))
    column = at - text.rfind("\n", 0, at)
    place = Span("r.xml", line, column)
    elements = behind.replace("<!-- <joint/> -->", "").replace("</", "")
    severity = Severity.WARNING if "<" in elements else Severity.INFO
    assert [(item.code, item.span, item.severity) for item in said] == [("ROBOT009", place, severity)]


@pytest.mark.parametrize("tail", ["\0", "\n\0\0 \r\n", "<!-- a -->\0"])
def test_nul_bytes_at_the_end(tail: str) -> None:
    """MuJoCo reads as far as the first; there is nothing to report."""
    text = "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>" + tail
    assert mujoco.MjModel.from_xml_string(text).ngeom == 1
    said = Collector()
    report_behind(parsed(text), said)
    assert not list(said)
    # A NUL inside is none at the end.
    assert "a control character, 0x00" in refused(text.replace("<geom", "\0<geom"))
    assert "a control character, 0x00" in refused(text + "\0text")


@pytest.mark.parametrize(
    ("head", "tail"),
    [
        pytest.param("<mujoco><!-- a -- b -->\n", "", id="dashes"),
        pytest.param("<mujoco><!-- a --->\n", "", id="three dashes"),
        pytest.param("<mujoco><!----- <joint name='no'/> ----->\n", "", id="a line"),
        pytest.param(
            "<mujoco model='m'><option timestep='1'gravity=\"0 0 -1\"integrator='Euler'/>\n",
            "",
            id="no space",
        ),
        pytest.param(
            "<mujoco model=\"a>b\"><!-- x='1'y -- --><compiler angle='radian'autolimits='true'/>\n",
            "",
            id="both",
        ),
        pytest.param("<mujoco>\n", "<!-- -- -->", id="behind"),
    ],
)
def test_what_mujoco_reads_is_read(head: str, tail: str) -> None:
    """Elements, their values and places are those of the file, which MuJoCo reads as well."""
    joint = "<joint type='hinge' name='knee'range='0 1' damping='1'/>"
    text = f"{head}<worldbody><body>{joint}<geom size='1'/></body></worldbody></mujoco>{tail}"
    model = mujoco.MjModel.from_xml_string(text)
    assert model.joint("knee").range[0] == 0.0 < model.joint("knee").range[1]
    document = parsed(text)
    (found,) = document.walk("joint")
    assert found.start == text.index(joint)
    assert document.span(found) == Span("r.xml", 2, text.index(joint) - text.index("\n"))
    assert [found.get(name) for name in ("name", "range")] == ["knee", "0 1"]
    value = found.attributes["range"]
    assert text[value.start : value.end] == "range='0 1'"


@pytest.mark.parametrize(
    "declaration",
    ["<?xml version='1.0' encoding='ISO-8859-1'?>", "<?xml version='1.0' encoding=\"utf8\"?>", ""],
)
def test_encodings_that_are_read(declaration: str) -> None:
    """ASCII under another declaration means the same; UTF-8 needs none, and no canonical spelling."""
    text = "e" if "ISO" in declaration else "é"
    assert parsed(f"{declaration}<a x='{text}'/>").root.get("x") == text


PIECES = [
    *(
        "<",
        ">",
        "/",
        "a",
        "=",
        '"',
        "'",
        " ",
        "\n",
        "\r",
        "&",
        "amp;",
        "&#1;",
        "\0",
        "é",
        "\ufeff",
        "-",
        "!",
        "]",
    ),
    *(
        "<a>",
        "</a>",
        "<a b='c'>",
        "<include file='x'/>",
        "<!--",
        "-->",
        "<![CDATA[",
        "]]>",
        "<?x",
        "?>",
        "<mujoco>",
    ),
    *(
        "<!DOCTYPE a [",
        "<!ENTITY b 'c'>",
        "&b;",
        "<?xml version='1.0' encoding='latin1'?>",
        "xmlns:b='c'",
        "</mujoco>",
    ),
]


@given(
    st.lists(st.sampled_from(PIECES), max_size=30).map("".join),
    st.sampled_from(["utf-8", "latin-1", "utf-16"]),
)
def test_no_text_breaks_the_parser(text: str, encoding: str) -> None:
    """Whatever a file holds, it is read, or refused with a place inside it."""
    data = text.encode(encoding, "replace")
    try:
        for element in parsed(data).walk():
            assert data[element.start : element.end].startswith(b"<" + element.tag.encode())
    except RobotError as err:
        for item in err.diagnostics:
            assert item.span is not None and 1 <= item.span.line <= text.count("\n") + text.count("\r") + 1
    except ValueError as err:
        assert "includes 'x', the files have None" in str(err)


def test_two_hundred_deep_is_read() -> None:
    """The depth limit is the last depth that is read."""
    assert sum(1 for _ in parsed("<a>" * 200 + "</a>" * 200).walk()) == 200


def test_too_many_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit of elements is the model's, not the file's: two of two files with two each pass 3."""
    monkeypatch.setattr(xml, "MOST_ELEMENTS", 4)
    main = ModelFile("main.xml", "", b'<mujoco><include file="b.xml"/></mujoco>')
    parse_document((main, ModelFile("b.xml", "b.xml", b"<mujoco><a/></mujoco>")))
    monkeypatch.setattr(xml, "MOST_ELEMENTS", 3)
    with pytest.raises(RobotError) as caught:
        parse_document((main, ModelFile("b.xml", "b.xml", b"<mujoco><a/></mujoco>")))
    assert str(caught.value) == "b.xml: ROBOT002: the model has more than 3 elements: 2 before this file"


BODY = '<mujoco><worldbody><body name="%s"><geom size="1"/></body></worldbody></mujoco>'


def including(*names: str) -> str:
    """An MJCF that only includes."""
    return "<mujoco>" + "".join(f'<include file="{name}"/>' for name in names) + "</mujoco>"


# name: files, bodies in order, or None where MuJoCo refuses.
LAYOUTS: dict[str, tuple[dict[str, str], list[str] | None]] = {
    "main folder first": (
        {
            "m/main.xml": including("s/a.xml"),
            "m/s/a.xml": including("b.xml"),
            "m/b.xml": BODY % "main",
            "m/s/b.xml": BODY % "sub",
        },
        ["main"],
    ),
    "else the including folder": (
        {"m/main.xml": including("s/a.xml"), "m/s/a.xml": including("b.xml"), "m/s/b.xml": BODY % "sub"},
        ["sub"],
    ),
    "not from the working folder": ({"m/main.xml": including("b.xml"), "b.xml": BODY % "cwd"}, None),
    "not from a folder between": (
        {
            "m/main.xml": including("s/a.xml"),
            "m/s/a.xml": including("t/b.xml"),
            "m/s/t/b.xml": including("c.xml"),
            "m/s/c.xml": BODY % "s",
        },
        None,
    ),
    "where the including file was found": (
        {
            "m/main.xml": including("s/a.xml"),
            "m/s/a.xml": including("t/b.xml"),
            "m/t/b.xml": including("c.xml"),
            "m/t/c.xml": BODY % "t",
            "m/s/t/c.xml": BODY % "s/t",
        },
        ["t"],
    ),
    "up from main": (
        {
            "m/main.xml": including("s/a.xml"),
            "m/s/a.xml": including("../b.xml"),
            "b.xml": BODY % "above main",
            "m/b.xml": BODY % "above sub",
        },
        ["above main"],
    ),
    "text of the path": ({"m/main.xml": including("none/../b.xml"), "m/b.xml": BODY % "b"}, ["b"]),
    "absolute": (
        {
            "m/main.xml": including("$D/z/b.xml"),
            "z/b.xml": including("c.xml"),
            "z/c.xml": BODY % "z",
        },
        ["z"],
    ),
    "absolute missing": ({"m/main.xml": including("/none/b.xml"), "m/none/b.xml": BODY % "b"}, None),
    "backslash": ({"m/main.xml": including("s\\b.xml"), "m/s/b.xml": BODY % "b"}, ["b"]),
    "case": ({"m/main.xml": including("B.xml"), "m/b.xml": BODY % "b"}, None),
    "order": (
        {
            "m/main.xml": '<mujoco><worldbody><body name="x"><geom size="1"/><include file="b.xml"/></body>'
            '<body name="y"><geom size="1"/></body></worldbody></mujoco>',
            "m/b.xml": '<mujocoinclude><body name="b1"><geom size="1"/></body><include file="c.xml"/>'
            '<body name="b2"><geom size="1"/></body></mujocoinclude>',
            "m/c.xml": '<mujocoinclude><body name="c"><geom size="1"/></body></mujocoinclude>',
        },
        ["x", "b1", "c", "b2", "y"],
    ),
    "a body for a root": (
        {
            "m/main.xml": '<mujoco><worldbody><include file="b.xml"/></worldbody></mujoco>',
            "m/b.xml": '<body name="gone"><geom size="1"/><body name="arm"><geom size="1"/></body></body>',
        },
        ["arm"],
    ),
    "twice": ({"m/main.xml": including("b.xml", "./b.xml"), "m/b.xml": "<mujoco><option/></mujoco>"}, None),
    "twice, then below": (
        {
            "m/main.xml": including("b.xml", "a.xml"),
            "m/a.xml": including("b.xml"),
            "m/b.xml": "<mujoco><option/></mujoco>",
        },
        None,
    ),
    "same name elsewhere": (
        {"m/main.xml": including("x/b.xml", "y/b.xml"), "m/x/b.xml": BODY % "x", "m/y/b.xml": BODY % "y"},
        ["x", "y"],
    ),
    "circle": (
        {"m/main.xml": including("a.xml"), "m/a.xml": including("b.xml"), "m/b.xml": including("a.xml")},
        None,
    ),
    "circle to main": ({"m/main.xml": including("main.xml")}, None),
    "content": (
        {"m/main.xml": '<mujoco><include file="b.xml"><!-- --></include></mujoco>', "m/b.xml": BODY % "b"},
        None,
    ),
    "white space is no content": (
        {"m/main.xml": '<mujoco><include file="b.xml"> \n </include></mujoco>', "m/b.xml": BODY % "b"},
        ["b"],
    ),
    "empty": ({"m/main.xml": including("b.xml"), "m/b.xml": "<mujoco><!-- --></mujoco>"}, None),
    "no file": ({"m/main.xml": "<mujoco><include/></mujoco>"}, None),
    "missing": ({"m/main.xml": including("b.xml")}, None),
    "in a comment": ({"m/main.xml": "<mujoco><!-- <include file='b.xml'/> --></mujoco>"}, []),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_includes_are_mujocos(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies through includes, in order, and refusals, are those that MuJoCo itself gives."""
    mujoco = pytest.importorskip("mujoco")
    files, bodies = LAYOUTS[name]
    path = written(tmp_path, files)
    monkeypatch.chdir(tmp_path)
    try:
        model: Any = mujoco.MjSpec.from_file(path).compile()
        answer: list[str] | None = [model.body(i).name for i in range(1, model.nbody)]
    except ValueError:
        answer = None
    assert answer == bodies
    try:
        document = open_document(path)
    except RobotError as err:
        assert answer is None, str(err)
    else:
        assert [e.get("name") for e in document.walk("body")] == answer


def test_files_and_spans_of_includes(tmp_path: Path) -> None:
    """Each include is one entry, in document order, with its own text, path and spans."""
    path = written(
        tmp_path,
        {
            "m/main.xml": "<mujoco>\n" + '<include file="s/a.xml"/>\n<include file="c.xml"/></mujoco>',
            "m/s/a.xml": '<mujoco><x/>\n <include file="b.xml"/></mujoco>',
            "m/s/b.xml": "<mujoco>\n\n <y/></mujoco>",
            "m/c.xml": "<mujocoinclude><z/></mujocoinclude>",
        },
    )
    files = open_document(path).files
    folder = str(tmp_path / "m")
    assert [(f.path, f.include) for f in files] == [
        (path, ""),
        (f"{folder}/s/a.xml", "s/a.xml"),
        (f"{folder}/s/b.xml", "b.xml"),
        (f"{folder}/c.xml", "c.xml"),
    ]
    document = parse_document(files)
    assert [(e.tag, e.file) for e in document.root.children] == [("x", 1), ("y", 2), ("z", 3)]
    assert document.span(document.root.children[1]) == Span(f"{folder}/s/b.xml", 3, 2)
    assert [(i.name, i.index, i.element.file, i.element.line) for i in document.includes] == [
        ("s/a.xml", 1, 0, 2),
        ("b.xml", 2, 1, 2),
        ("c.xml", 3, 0, 3),
    ]
    assert not document.is_repeated(document.root.children[0])


def test_relative_main_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A nested include is found from a relative main path too, as in MuJoCo 4.0."""
    written(
        tmp_path,
        {"m/main.xml": including("s/a.xml"), "m/s/a.xml": including("b.xml"), "m/s/b.xml": BODY % "sub"},
    )
    monkeypatch.chdir(tmp_path)
    assert [f.path for f in open_document("m/main.xml").files] == ["m/main.xml", "m/s/a.xml", "m/s/b.xml"]


def test_file_included_by_two_others(tmp_path: Path) -> None:
    """MuJoCo until 3.17 reads such a file twice: two entries, and its elements are told."""
    path = written(
        tmp_path,
        {
            "m/main.xml": including("a.xml", "b.xml"),
            "m/a.xml": including("c.xml"),
            "m/b.xml": including("c.xml"),
            "m/c.xml": "<mujoco><x/></mujoco>",
        },
    )
    document = open_document(path)
    first, second = document.walk("x")
    assert (first.file, second.file) == (2, 4)
    assert document.is_repeated(first) and not document.is_repeated(document.root)


def test_urdf_has_no_includes() -> None:
    """MuJoCo does not look for includes in a URDF, so a missing file there is no error."""
    document = parsed('<robot><include file="none.xml"/></robot>')
    assert [e.tag for e in document.walk()] == ["robot", "include"]
    assert document.includes == ()


@pytest.mark.parametrize(
    ("secret", "kind"),
    [
        pytest.param("root:x:0:0:hunter2\n", "is not an MJCF file", id="text"),
        pytest.param("<hunter2><a/></hunter2>", "is not an MJCF file", id="other xml"),
        pytest.param("<hunter2><a></hunter2>", "is not an MJCF file", id="broken other xml"),
        pytest.param("<hunter2 hunter2=hunter2/>", "is not an MJCF file", id="broken tag"),
        pytest.param("hunter2 \0\1", "is not an MJCF file", id="binary"),
    ],
)
def test_content_of_a_foreign_file_is_never_shown(secret: str, kind: str, tmp_path: Path) -> None:
    """An include of any file of the machine says that it is no MJCF, and nothing of what is in it."""
    path = written(tmp_path, {"m/main.xml": including("../secret"), "secret": secret})
    with pytest.raises(RobotError) as caught:
        open_document(path)
    assert str(caught.value) == (
        f"{path}:1:9: ROBOT008: the included file '../secret' {kind}\n"
        "  help: an included file is XML with the root <mujocoinclude> or <mujoco>, or with elements of MJCF alone"
    )


@pytest.mark.parametrize(
    ("inside", "read"),
    [("<asset/><option timestep='0.1'/>", True), ("<asset/><password/>", False), ("", False)],
)
def test_a_root_of_any_name(inside: str, read: bool, tmp_path: Path) -> None:
    """MuJoCo takes any root of an include away; what has nothing but sections of MJCF in it is one."""
    path = written(
        tmp_path, {"m/main.xml": including("parts.xml"), "m/parts.xml": f"<parts>{inside}</parts>"}
    )
    if not read:
        with pytest.raises(RobotError, match="ROBOT008"):
            open_document(path)
        return
    assert [element.tag for element in open_document(path).walk()] == ["mujoco", "asset", "option"]
    assert mujoco.MjModel.from_xml_path(str(path)).opt.timestep == 0.1


def test_a_root_of_any_name_around_assets(tmp_path: Path) -> None:
    """As that of a list of meshes that stands in the assets of what includes it."""
    path = written(
        tmp_path,
        {
            "m/main.xml": "<mujoco><asset><include file='all.xml'/></asset></mujoco>",
            "m/all.xml": "<textures><texture name='a' type='skybox' builtin='flat' width='8' height='8'/></textures>",
        },
    )
    assert [element.tag for element in open_document(path).walk()] == ["mujoco", "asset", "texture"]
    assert mujoco.MjModel.from_xml_path(str(path)).ntex == 1


def test_a_root_of_any_name_around_what_a_body_has(tmp_path: Path) -> None:
    """As that of an object's geoms, which its body includes: <bottle><geom/></bottle>."""
    path = written(
        tmp_path,
        {
            "m/main.xml": "<mujoco><worldbody><body><include file='bottle.xml'/></body></worldbody></mujoco>",
            "m/bottle.xml": "<bottle><freejoint/><geom size='0.1'/></bottle>",
        },
    )
    tags = ["mujoco", "worldbody", "body", "freejoint", "geom"]
    assert [element.tag for element in open_document(path).walk()] == tags
    assert mujoco.MjModel.from_xml_path(str(path)).nv == 6


def test_a_root_of_any_name_around_actuators(tmp_path: Path) -> None:
    """As that of motors, or <mujocoinclude> in other letters; one with more is no part."""
    main = (
        "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody>"
        "<actuator><include file='motors.xml'/></actuator></mujoco>"
    )
    motors = "<MujocoInclude><motor joint='j'/><damper joint='j' kv='1' ctrlrange='0 1'/></MujocoInclude>"
    path = written(tmp_path, {"m/main.xml": main, "m/motors.xml": motors})
    assert [element.tag for element in open_document(path).walk()][-2:] == ["motor", "damper"]
    assert mujoco.MjModel.from_xml_path(str(path)).nu == 2
    Path(path).with_name("motors.xml").write_text("<robot><motor/><link/></robot>")
    with pytest.raises(RobotError, match="ROBOT008"):
        open_document(path)


def test_an_error_inside_an_include_has_its_own_place(tmp_path: Path) -> None:
    """Once the root shows that a file is an MJCF, its errors are given in full, at its own lines."""
    path = written(tmp_path, {"m/main.xml": including("b.xml"), "m/b.xml": "<mujoco>\n<a>\n</mujoco>"})
    with pytest.raises(RobotError) as caught:
        open_document(path)
    assert str(caught.value) == (
        f"{tmp_path}/m/b.xml:3:3: ROBOT004: </mujoco> stands where <a> (line 2) is to be closed"
    )


def test_all_include_errors_at_once(tmp_path: Path) -> None:
    """Errors of several includes are collected, each with the place, the paths tried and a near name."""
    path = written(
        tmp_path,
        {
            "m/main.xml": "<mujoco>"
            + '\n<include file="leg.xml"/>\n<include/>\n<include file="s"/></mujoco>',
            "m/legs.xml": BODY % "b",
            "m/s/x": "",
        },
    )
    with pytest.raises(RobotError) as caught:
        open_document(path)
    assert [str(d) for d in caught.value.diagnostics] == [
        f"{path}:2:1: ROBOT006: the include cannot be followed: there is no file 'leg.xml'\n"
        f"  help: tried {tmp_path}/m/leg.xml; did you mean 'legs.xml'?",
        f'{path}:3:1: ROBOT006: an include without a file\n  help: write file="..."',
        f"{path}:4:1: ROBOT006: the include cannot be followed: '{tmp_path}/m/s' is a folder",
    ]


@pytest.mark.parametrize(
    ("name", "message", "tried"),
    [
        ("../sim/arm/leg.xml", "there is no folder '../sim'", "{0}/sim, {0}/m/sim"),
        (
            "part/a/leg.xml",
            "there is no folder 'part'",
            "{0}/m/part, {0}/m/parts/part; did you mean 'parts'?",
        ),
        ("..\\m\\gone\\leg.xml", "there is no folder '../m/gone'", "{0}/m/gone, {0}/m/m/gone"),
        (
            "/gone/arm/leg.xml",
            "there is no folder '/gone'",
            "/gone; an absolute path works on one machine only",
        ),
        # All folders are there; what stands in the place of one is a file; the drive of another system.
        ("../m/leg.xml", "there is no file '../m/leg.xml'", "{0}/m/leg.xml, {0}/m/m/leg.xml"),
        (
            "main.xml/leg.xml",
            "there is no file 'main.xml/leg.xml'",
            "{0}/m/main.xml/leg.xml, {0}/m/parts/main.xml/leg.xml",
        ),
        ("C:/sim/leg.xml", "there is no file 'C:/sim/leg.xml'", "C:/sim/leg.xml"),
        # As it is written, on one line.
        ("C:\\sim\\leg.xml", "there is no file 'C:\\sim\\leg.xml'", "C:/sim/leg.xml"),
        ("C:\\&#10;l'g.xml", 'there is no file "C:\\\\nl\'g.xml"', "C:/\nl'g.xml"),
    ],
)
def test_a_folder_that_is_not_there(tmp_path: Path, name: str, message: str, tried: str) -> None:
    """It is the outermost that is told, where the file was looked for: beside the main file and beside the part."""
    path = written(tmp_path, {"m/main.xml": including("parts/a.xml"), "m/parts/a.xml": including(name)})
    with pytest.raises(RobotError) as caught:
        open_document(path)
    (told,) = caught.value.diagnostics
    assert (told.message, told.help) == (
        f"the include cannot be followed: {message}",
        f"tried {tried.format(tmp_path)}",
    )


def test_circle_names_the_chain(tmp_path: Path) -> None:
    """The error of a circle lists the files from the first of it back to itself."""
    path = written(
        tmp_path,
        {"m/main.xml": including("a.xml"), "m/a.xml": including("b.xml"), "m/b.xml": including("a.xml")},
    )
    with pytest.raises(RobotError) as caught:
        open_document(path)
    folder = tmp_path / "m"
    assert str(caught.value) == (
        f"{folder}/b.xml:1:9: ROBOT007: the includes go in a circle: "
        f"{folder}/a.xml -> {folder}/b.xml -> {folder}/a.xml"
    )


def test_a_part_that_includes_again_is_not_at_fault(tmp_path: Path) -> None:
    """MuJoCo takes `b.xml` by itself; the main file includes both, and is told at its second include."""
    main = '<mujoco>\n<include file="a.xml"/>\n<include file="b.xml"/>\n</mujoco>'
    part = "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
    path = written(tmp_path, {"m/main.xml": main, "m/b.xml": including("a.xml"), "m/a.xml": part})
    assert mujoco.MjModel.from_xml_path(f"{tmp_path}/m/b.xml").ngeom == 1
    with pytest.raises(ValueError, match="already included"):
        mujoco.MjModel.from_xml_path(path)
    with pytest.raises(RobotError) as caught:
        open_document(path)
    (told,) = caught.value.diagnostics
    assert str(told.span) == f"{path}:3:1"
    assert told.message == "'a.xml' is included already, and 'b.xml' includes it again, which MuJoCo refuses"


def test_repeated_includes_do_not_explode(tmp_path: Path) -> None:
    """Files that include two others that both include the next would double at each step."""
    files = {"m/main.xml": including("a0.xml")}
    for step in range(20):
        files[f"m/a{step}.xml"] = including(f"b{step}.xml", f"c{step}.xml")
        files[f"m/b{step}.xml"] = files[f"m/c{step}.xml"] = including(f"a{step + 1}.xml")
    files["m/a20.xml"] = "<mujoco><option/></mujoco>"
    with pytest.raises(RobotError, match=r"ROBOT002: more than 1000 includes, or 64 in a chain$"):
        open_document(written(tmp_path, files))


@pytest.mark.slow
def test_many_faulty_includes_end_soon() -> None:
    """Collecting their errors cannot take for ever: the thousandth ends it."""
    said = refused("<mujoco>" + "<include/>" * 100_000 + "</mujoco>").splitlines()
    assert said[-1] == "r.xml:1:9999: ENV004: stopped at 1000 errors"
    assert said[0] == "r.xml:1:9: ROBOT006: an include without a file"


def test_pipes_devices_and_folders_are_refused(tmp_path: Path) -> None:
    """Only regular files are read; a pipe without a writer would wait for ever."""
    os.mkfifo(tmp_path / "pipe")
    for name, kind in ((str(tmp_path / "pipe"), "not a regular file"), ("/dev/zero", "not a regular file")):
        with pytest.raises(RobotError) as caught:
            open_document(name)
        assert str(caught.value) == f"{name}: ROBOT001: {name!r} is {kind}"
        path = written(tmp_path, {"m/main.xml": including(name)})
        with pytest.raises(RobotError) as caught:
            open_document(path)
        assert str(caught.value).endswith(f"ROBOT006: the include cannot be followed: {name!r} is {kind}")
    for name in (str(tmp_path / "none.xml"), str(tmp_path / "m" / "main.xml" / "x"), "a\0b", "a" * 5000):
        with pytest.raises(RobotError, match="ROBOT001"):
            open_document(name)


def test_large_file_is_refused(tmp_path: Path) -> None:
    """A file of one byte more than 64 MiB is refused before it is parsed."""
    path = tmp_path / "big.xml"
    with path.open("wb") as stream:
        stream.truncate(64 * 1024 * 1024 + 1)
    with pytest.raises(RobotError) as caught:
        open_document(str(path))
    assert str(caught.value) == f"{path}: ROBOT001: {str(path)!r} is larger than 64 MiB"


def test_files_must_fit_the_includes() -> None:
    """Files that are not those of the includes are a mistake of the caller."""
    main = ModelFile("main.xml", "", including("b.xml").encode())
    other = ModelFile("c.xml", "c.xml", b"<mujoco><a/></mujoco>")
    with pytest.raises(ValueError, match=r"includes 'b\.xml', the files have None"):
        parse_document((main,))
    with pytest.raises(ValueError, match=r"includes 'b\.xml', the files have 'c\.xml'"):
        parse_document((main, other))
    with pytest.raises(ValueError, match="more files than includes"):
        parse_document((ModelFile("a.xml", "", b"<mujoco/>"), other))


def _flat(element: Element) -> Iterator[tuple[str, dict[str, str]]]:
    """Tags and attributes, without what comes from includes."""
    yield (
        element.tag,
        {name: a.value for name, a in element.attributes.items() if not name.startswith("xmlns")},
    )
    for child in element.children:
        if child.file == element.file:
            yield from _flat(child)


@pytest.mark.slow
@pytest.mark.parametrize("path", MODELS, ids=MODEL_IDS)
def test_real_files_as_lxml_reads_them(path: Path) -> None:
    """Tags, attributes, their order and the lines of every real file are those of lxml."""
    etree = pytest.importorskip("lxml.etree")
    data = path.read_bytes()
    document = open_document(str(path))
    if path == CORPUS / BROKEN:
        # Behind its root it has a closing tag more.
        with pytest.raises(etree.XMLSyntaxError):
            etree.fromstring(data)
        data = data[: document.root.end]
    theirs = [
        (f"{e.prefix}:{etree.QName(e).localname}" if e.prefix else e.tag, dict(e.attrib))
        for e in etree.fromstring(data).iter(etree.Element)
        if e.tag != "include"
    ]
    assert list(_flat(document.root)) == theirs
    lines = [e.sourceline for e in etree.fromstring(data).iter(etree.Element) if e.tag != "include"]
    own = [e for e in document.walk() if e.file == 0]
    for element, line in zip(own, lines, strict=True):
        # libxml2 gives the line on which the start tag ends.
        assert data.count(b"\n", 0, element.open_end) + 1 == line
        assert data.count(b"\n", 0, element.start) + 1 == element.line
        start = data.rfind(b"\n", 0, element.start) + 1
        assert len(data[start : element.start].decode()) + 1 == element.column
        assert data[element.start :].startswith(b"<" + element.tag.encode())
        assert data[element.end - 1 : element.end] == b">"
        for attribute in element.attributes.values():
            assert data[attribute.start :].startswith(attribute.name.encode())
            raw = data[attribute.value_start : attribute.value_end].replace(b"\r\n", b"\n").decode()
            assert raw.translate({9: " ", 10: " "}) == attribute.value
            assert data[attribute.value_end] == data[attribute.value_start - 1]
