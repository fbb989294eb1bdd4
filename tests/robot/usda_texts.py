"""Statements of USD's text form and what they mean: of them the reader is held to USD itself, in tests/frameworks."""

from __future__ import annotations

import math
from typing import Any

from actspec.robot.usda import Asset

HEAD = "#usda 1.0\n"


def within(statements: str, metadata: str = "") -> str:
    """A layer with one prim `/a` that says these things."""
    return f'{HEAD}def Scope "a" {metadata}{{\n{statements}\n}}\n'


VALUES: dict[str, Any] = {
    "float x = 1": 1.0,
    "float x = .5": 0.5,
    "float x = 5.": 5.0,
    "float x = -1.5e3": -1500.0,
    "float x = 01": 1.0,
    "float x = -inf": -math.inf,
    "float x = inf": math.inf,
    "float x = 1e39": math.inf,
    "float x = 3.4028235e38": 3.4028235e38,
    "half x = 70000": math.inf,
    "double x = 1e39": 1e39,
    "int x = -3": -3,
    "int x = 2.9": 2,
    "int x = 1e3": 1000,
    "bool x = true": True,
    "bool x = 2": True,
    "bool x = 0.0": False,
    "token x = 't'": "t",
    r'string x = "a\nb\x41\101\q\"c"': 'a\nbAAq"c',
    "string x = 'a\"b'": 'a"b',
    'string x = """a\nb"c"""': 'a\nb"c',
    "string x = '''a\n'b'''": "a\n'b",
    r'string x = """a\"""b"""': 'a"""b',
    'string x = ""': "",
    'string x = "a // b # c /* d } {"': "a // b # c /* d } {",
    'string x = "関é"': "関é",
    "asset x = @a.onnx@": Asset("a.onnx"),
    "asset x = @@@a@b.onnx@@@": Asset("a@b.onnx"),
    r"asset x = @@@a\@@@b@@@": Asset("a@@@b"),
    "asset x = @@": Asset(""),
    "float[] x = [1, 2,\n3,]": (1.0, 2.0, 3.0),
    "float[] x = []": (),
    "float3[] x = [(1, 2, 3), (4, 5, 6)]": ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)),
    'token[] x = ["a", "b"]': ("a", "b"),
    "asset[] x = [@a@, @b@]": (Asset("a"), Asset("b")),
    "float x": None,
    "float x = None": None,
    "custom uniform token x = 'a'": "a",
    "float x = 1; float y = 2": 1.0,
    "float x = 1;": 1.0,
    "float x = 1 (\ndoc = 'hi'\n)": 1.0,
    "float x = 1 ('hi')": 1.0,
    "float x = 1 (doc = 'a'; hidden = true)": 1.0,
    "float x (\ndoc = 'a')": None,
    "float x = 1 (customData = {string a = 'b'; dictionary c = {int d = 1}})": 1.0,
    "# a\nfloat x = 1  # b": 1.0,
    "/* a\n* b */ float x = 1 // c": 1.0,
    "float x = /* c */ 1": 1.0,
    "float y = 2\r\nfloat x = 1\r": 1.0,
    "float x = 1\nfloat x = 2": 2.0,
    "float x = 1\nfloat x": 1.0,
    "float x = 1\nfloat x = None": None,
    "reorder properties = ['x']\nfloat x = 1": 1.0,
    "reorder nameChildren = ['b']\nfloat x = 1": 1.0,
    'float x = 1\ndef "b"\n{\n}': 1.0,
}
"""Contents of a prim to the value of its `x`."""

REFUSED = (
    "float x = +1", "float x = 0x10", "float x = 1_000", "float x = --1", "float x = ", "float x =\n1", "float x\n= 1",
    "float\nx = 1", "float = 1", 'float "x" = 1', "float x = 1 2", "float x = 1 float y = 2", "float x = 1;;",
    "float x = 1 /* c\n */ float y = 2",
    "float x = 1,", "float x = 1)", "float x = [1]", "float x = (1)", 'float x = "1"', "float x = 1.0.0",
    "float[] x = 1", "float[] x = [1 2]", "float[] x = [1, 2", "int x = 99999999999", "int x = inf", "uint x = -1",
    "uchar x = 300",
    "bool x = maybe", "token x = t", 'string x = "a\nb"', 'string x = "a', r'string x = "a\"', "string x = '''a''",
    "string x = 1", "asset x = @a\nb@", "asset x = @a", "rel r = <b", "rel r = <>", "rel r = </>", "rel r = </1b>",
    "rel r = </b/>", "rel r = </b c>", "rel r = <../../b>", "rel r = <../>", "rel r = <..>",
    'rel r = "b"', "rel r =\n</b>", "rel r = [</b>, </b>]",
    "float x = 1 (1)", "float x = 1 (doc = )", "float x = 1 (doc = 'a' hidden = true)", "float x = 1\n(doc = 'a')",
    "float x = 1 (doc = 'a'", "float x = 1 (doc = ['a'", "float x = 1\nint x = 2", "add float x = 1", 'def "1b" {}',
    'def "b-c" {}', "def b {}", 'def "b" {} def "c" {}', 'def "b" {}\ndef "b" {}', 'def "b"', "}", ")", "{", "$",
    "/* a",
)  # fmt: skip
"""Contents of a prim that are none."""

NOT_READ = {
    "float x.timeSamples = {0: 1}": "3:7: USDA002: timeSamples of x, and only plain values are read",
    "float x.connect = </b.y>": "3:7: USDA002: connect of x, and only plain values are read",
    'variantSet "v" = {"a" {}}': "3:1: USDA002: a variantSet, which is not read",
}
"""Contents of a prim that USD takes; the place and what is said."""

SCHEMAS: dict[str, tuple[str, ...]] = {
    '(prepend apiSchemas = ["A", "B"])': ("A", "B"),
    '(prepend apiSchemas = [\n"A",\n"B"\n])': ("A", "B"),
    '(apiSchemas = ["A"])': ("A",),
    '(apiSchemas = [])': (),
    '(apiSchemas = None)': (),
    '(delete apiSchemas = ["A"])': (),
    '(append apiSchemas = ["B"]\nprepend apiSchemas = ["A"]\n)': ("A", "B"),
    '(append apiSchemas = ["A"]\nprepend apiSchemas = ["A", "B"])': ("B", "A"),
    '(add apiSchemas = ["A"]\nprepend apiSchemas = ["B"])': ("B", "A"),
    '(apiSchemas = ["A"]\nprepend apiSchemas = ["B"])': ("B",),
    '(prepend apiSchemas = ["B"]\napiSchemas = ["A"])': ("A",),
    '(prepend apiSchemas = ["A", "B"]\ndelete apiSchemas = ["A"])': ("A", "B"),
    '(prepend apiSchemas = ["A"]\nprepend apiSchemas = ["B"])': ("B",),
    '(references = [@x.usda@</b> (offset = 1), </c>]; prepend apiSchemas = ["A"])': ("A",),
    '(prepend payload = @x.usda@</b> (offset = 1; scale = 2)\nprepend apiSchemas = ["A"])': ("A",),
    '("""doc"""\nkind = "component"; prepend apiSchemas = ["A"])': ("A",),
    '(customData = {int a = 1\nstring b = "c"\n}\nprepend apiSchemas = ["A"])': ("A",),
    "()": (),
}  # fmt: skip
"""Metadata of a prim to its API schemas."""

TARGETS: dict[str, tuple[str, ...]] = {
    "rel r = </b>": ("/b",),
    "rel r = [\n</b>,\n</c.x:y>\n]": ("/b", "/c.x:y"),
    "rel r = []": (),
    "rel r = None": (),
    "rel r": (),
    "rel r = <b/c>": ("/a/b/c",),
    "rel r = <../b>": ("/b",),
    "rel r = <.x>": ("/a.x",),
    'def "b" {\n}\nrel r = <b>': ("/a/b",),
    "prepend rel r = </b>\nappend rel r = </c>": ("/b", "/c"),
    "prepend rel r = </b>\nprepend rel r = </c>": ("/c",),
    "rel r = </b>\nprepend rel r = </c>": ("/c",),
    "rel r = </b>\ndelete rel r = </b>": (),
    "rel r = </b>\nrel r": ("/b",),
    "custom rel r = </b> (\ndoc = 'x')": ("/b",),
}
"""Contents of a prim to the targets of its `r`."""

REFUSED_LAYERS = (
    "(\n", "(a = 1", "(;)", 'def "a" {', 'def "a" {}}', "float x = 1", 'def "a" {} def "b" {}', 'def "a" {}\n(\n)',
    'def "a" {};', 'def "a/b" {}', 'def "" {}', 'def\n"a" {}', 'def Scope\n"a" {}', 'undef "a" {}', "\0",
    'def "a" (active = false', 'def "a" (active = false active = true) {}', 'def "a" (prepend\napiSchemas = ["A"]) {}',
    'def "a" (prepend apiSchemas =\n["A"]) {}', 'def "a" (prepend apiSchemas = "A") {}',
    'def "a" (prepend apiSchemas = [1]) {}', 'def "a" (;\nactive = false) {}', 'def "a" { def "b" {} }',
)  # fmt: skip
"""Layers, without their first line, that are none."""
