"""Joint patterns: the meaning of `re.fullmatch`, refusals, suggestions, and no hanging."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from actspec.patterns import (
    MAX_NAME,
    MAX_PATTERN,
    MAX_STEPS,
    PatternError,
    PatternProblem,
    compile_pattern,
    covering_pattern,
    match_names,
    recased,
    resolve_patterns,
    suggest_pattern,
    written_out,
)

LEGS = tuple(f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf"))
NESTED = "a repeat inside a repeat, which can take forever (catastrophic backtracking)"
SIMPLER = "write a simpler pattern: one `.*` per gap, no repeat inside a repeat; or list the joints by name"


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        pytest.param("FL_hip_joint", ("FL_hip_joint",), id="a name is a pattern"),
        pytest.param("hip", (), id="not a search"),
        pytest.param("FL_hip", (), id="not a prefix match"),
        pytest.param(".*_calf_joint", tuple(n for n in LEGS if "calf" in n), id="wildcard"),
        pytest.param(
            "R._hip_joint|FL_calf_joint", ("FL_calf_joint", "RL_hip_joint", "RR_hip_joint"), id="or"
        ),
        pytest.param("FL_hip_joint|F", ("FL_hip_joint",), id="or is matched as a whole"),
        pytest.param("F|FL_hip_joint", ("FL_hip_joint",), id="a short first alternative does not win"),
        pytest.param("[FR]L_(?:hip|calf)_.{5}", (LEGS[0], LEGS[2], LEGS[6], LEGS[8]), id="class"),
        pytest.param("^(?!F).*hip_joint$", ("RL_hip_joint", "RR_hip_joint"), id="lookahead and anchors"),
        pytest.param("(?i)fl_HIP.*", ("FL_hip_joint",), id="flag in front"),
        pytest.param("(.*_)?RR_hip(_joint)?", ("RR_hip_joint",), id="an optional group may hold a repeat"),
        pytest.param(
            "(?:FL|RL)+_calf_joint", ("FL_calf_joint", "RL_calf_joint"), id="a fixed part may repeat"
        ),
        pytest.param("FL_*", (), id="a star repeats the letter before it"),
    ],
)
def test_a_pattern_matches_whole_names_in_their_order(pattern: str, expected: tuple[str, ...]) -> None:
    """The names come in the order of the robot, each matched from its first to its last letter."""
    assert match_names(pattern, LEGS) == expected


def test_the_order_is_that_of_the_names() -> None:
    """Reversed names give a reversed result: nothing sorts."""
    expected = ("RR_hip_joint", "RL_hip_joint", "FR_hip_joint", "FL_hip_joint")
    assert match_names(".*hip_joint", LEGS[::-1]) == expected


def test_a_name_with_a_line_break_at_its_end_is_not_matched_by_dollar() -> None:
    """`$` matches before a final line break, but a full match still has to take it."""
    assert match_names("FL$", ["FL\n", "FL"]) == ("FL",)


ATOM = st.sampled_from(
    [
        "a",
        "b",
        ".",
        "[ab]",
        "[^a]",
        "(?:a|ab)",
        "(b|ba|a)",
        "a?",
        "b*",
        ".*",
        "(?=a)",
        "(?:ab)+",
        "a{1,2}?",
        "b{2}",
    ]
)


@pytest.mark.slow
@settings(max_examples=300, deadline=None, database=None)
@given(st.lists(ATOM, min_size=1, max_size=6).map("".join), st.lists(st.text("ab", max_size=8), max_size=5))
def test_the_meaning_is_that_of_fullmatch(pattern: str, names: list[str]) -> None:
    """Whatever is not refused means what Isaac Lab and mjlab will read."""
    assert match_names(pattern, names) == tuple(n for n in names if re.fullmatch(pattern, n))


@pytest.mark.parametrize(
    ("pattern", "message", "help"),
    [
        pytest.param("", "the pattern is empty", "`.*` matches every joint", id="empty"),
        pytest.param(
            "*_hip_joint",
            "'*_hip_joint' is not a regular expression: nothing to repeat at character 1",
            "patterns are regular expressions, not globs: write '.*_hip_joint'",
            id="glob",
        ),
        pytest.param(
            "?L_*_joint",
            "'?L_*_joint' is not a regular expression: nothing to repeat at character 1",
            "patterns are regular expressions, not globs: write '.L_.*_joint'",
            id="glob with question mark",
        ),
        pytest.param(
            "FL_(hip",
            "'FL_(hip' is not a regular expression: missing ), unterminated subpattern at character 4",
            "a pattern is a Python regular expression that matches the whole name, such as '.*_hip_joint'",
            id="open group",
        ),
        pytest.param("(a+)+$", "'(a+)+$' has " + NESTED, SIMPLER, id="nested"),
        pytest.param(
            "(?:x(?:.*y|z)){2,}", "'(?:x(?:.*y|z)){2,}' has " + NESTED, SIMPLER, id="nested in a branch"
        ),
        pytest.param("(?:|a)*", "'(?:|a)*' has " + NESTED, SIMPLER, id="repeated empty"),
        pytest.param("(?=x|(a+)+)y", "'(?=x|(a+)+)y' has " + NESTED, SIMPLER, id="nested in a lookahead"),
        pytest.param("((a*)+)?y", "'((a*)+)?y' has " + NESTED, SIMPLER, id="nested in a group"),
        pytest.param(
            r"(.)\1", r"'(.)\1' refers back to a group, which patterns may not", SIMPLER, id="backreference"
        ),
        pytest.param(
            "(a)?(?(1)b|c)",
            "'(a)?(?(1)b|c)' refers back to a group, which patterns may not",
            SIMPLER,
            id="conditional",
        ),
        pytest.param("a{1001}", "'a{1001}' repeats more than 1000 times", SIMPLER, id="many repeats"),
        pytest.param(
            "a{0,1001}", "'a{0,1001}' repeats more than 1000 times", SIMPLER, id="many optional repeats"
        ),
        pytest.param(
            "a{99999999999999999999}",
            "'a{99999999999999999999}' is not a usable regular expression:"
            " the repetition number is too large",
            SIMPLER,
            id="overflow",
        ),
        pytest.param(
            "x" * 257,
            "the pattern has 257 characters, at most 256 are allowed",
            "split it into several patterns",
            id="long",
        ),
        pytest.param(
            "[[a]b]",
            "'[[a]b]' is read differently by different Python versions: Possible nested set at position 1",
            "escape `[`, `-`, `&`, `|`, `~` in a class by `\\`; put flags first",
            id="nested set",
        ),
    ],
)
def test_a_refused_pattern_says_why_and_what_to_write(pattern: str, message: str, help: str) -> None:
    """Message and help in full."""
    with pytest.raises(PatternError) as caught:
        compile_pattern(pattern)
    assert (caught.value.message, caught.value.help) == (message, help)
    assert str(caught.value) == message


@pytest.mark.parametrize("pattern", [r"\p{Lu}.*", "(?|a|b)", "a(?i)b", r"a\K", "(?R)", "(?L)a", "a\\"])
def test_syntax_that_re_does_not_know_is_refused(pattern: str) -> None:
    """What only other engines know would fail in the simulator."""
    with pytest.raises(PatternError):
        compile_pattern(pattern)


@pytest.mark.parametrize("pattern", ["a++", "a*+b", "a?+", "(?>ab)c", "x(a|b++)"])
def test_syntax_newer_than_python_3_10_is_refused(pattern: str) -> None:
    """Python 3.11 knows possessive repeats and atomic groups; Isaac Lab 2.x runs on 3.10."""
    with pytest.raises(PatternError):
        compile_pattern(pattern)


def test_the_longest_pattern_is_accepted() -> None:
    """256 characters are allowed, 257 are not (above)."""
    assert match_names("x" * MAX_PATTERN, ["x" * MAX_PATTERN]) == ("x" * MAX_PATTERN,)


HANGING = "a" * 40 + "!"
TOO_LONG = "could take too long (catastrophic backtracking)"


@pytest.mark.parametrize(
    ("pattern", "name"),
    [
        pytest.param("(a+)+$", HANGING, id="repeat in a repeat"),
        pytest.param("([a-z]+)*$", HANGING, id="class in a repeat"),
        pytest.param("(a|aa)+$", HANGING, id="ambiguous alternatives, 2.7e8 paths"),
        pytest.param("a?" * 40 + "a" * 40 + "$", HANGING, id="optional letters, 2^40 paths"),
        pytest.param("(?:a|.)" * 36 + "b", HANGING, id="alternatives in a row, 2^36 paths"),
        pytest.param(".*" * 12 + "b", HANGING, id="wildcards in a row, C(52,12) paths"),
        pytest.param("(?=" + ".*" * 12 + "b).*", HANGING, id="inside a lookahead"),
        pytest.param("(?:(?:a{0,900}){0,900}){0,900}b", HANGING, id="counted repeats"),
    ],
)
def test_a_pattern_that_hangs_re_is_an_error(pattern: str, name: str) -> None:
    """Each of these keeps `re.fullmatch` busy for hours; here it ends with a reason."""
    with pytest.raises(PatternError, match="catastrophic backtracking") as caught:
        match_names(pattern, [name])
    assert caught.value.help == SIMPLER


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        pytest.param(
            ".*_.*_.*_.*_joint", [f"left_hand_thumb_{i}_rotation_joint" for i in range(60)], id="4 gaps"
        ),
        pytest.param(
            "(left|right)_(hip|shoulder)_(pitch|roll|yaw)_joint", ["left_hip_yaw_joint"] * 60, id="words"
        ),
        pytest.param("((a{1000}){1000}){1000}", ["aaa"], id="fixed counts need no choice"),
        pytest.param("(" * 100 + "aaa" + ")" * 100, ["aaa"], id="deep groups"),
    ],
)
def test_an_honest_pattern_is_not_called_catastrophic(pattern: str, names: list[str]) -> None:
    """The bound leaves room for the patterns that people write."""
    assert match_names(pattern, names) in ((), tuple(names))


def test_the_work_is_bounded_over_all_names_together() -> None:
    """One name may cost 1/1 of the steps, a thousand names 1/1000 each."""
    # 7 gaps on 30 letters: C(37,7) = 10 295 472 paths reach the end, below MAX_STEPS = 50 000 000 once.
    pattern = ".*" * 7 + "b"
    assert MAX_STEPS == 50_000_000
    assert match_names(pattern, ["a" * 30]) == ()
    with pytest.raises(PatternError, match=re.escape(TOO_LONG)):
        match_names(pattern, ["a" * 30] * 1000)


def test_a_name_that_no_robot_has_is_refused() -> None:
    """A name of a hundred thousand letters is an attack or a mistake, and costs nothing."""
    assert match_names("a.*", ["a" * MAX_NAME]) == ("a" * MAX_NAME,)
    with pytest.raises(PatternError) as caught:
        match_names("a.*", ["a" * (MAX_NAME + 1)])
    assert caught.value.message == "a joint's name has 513 characters, at most 512 are matched"


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        pytest.param(".*_claf_joint", ".*_calf_joint", id="letters swapped"),
        pytest.param(".*_HIP_joint", ".*_hip_joint", id="case"),
        pytest.param("FL_hip_join", "FL_hip_joint", id="letter missing at the end"),
        pytest.param("FLhip_joint", "FL_hip_joint", id="letter missing inside"),
        pytest.param("(FL|FR)_hpi_joint", "(FL|FR)_hip_joint", id="behind a group"),
        pytest.param("[FR]L_clf_.*", "[FR]L_calf_.*", id="between a class and a wildcard"),
        pytest.param("FL_*", "FL_.*", id="glob that is a valid regex"),
        pytest.param("hip_joint", ".*hip_joint", id="end of names"),
        pytest.param(".*_hip", ".*_hip.*", id="written as a search"),
        pytest.param("thigh", ".*thigh.*", id="a word inside"),
        pytest.param("wheel_.*", None, id="nothing near"),
        pytest.param("", None, id="empty"),
        pytest.param("(a+)+$", None, id="refused"),
    ],
)
def test_the_nearest_pattern_is_suggested(pattern: str, expected: str | None) -> None:
    """A suggestion is near the author's text and matches at least one joint."""
    assert suggest_pattern(pattern, LEGS) == expected
    assert expected is None or match_names(expected, LEGS)


def test_a_suggestion_on_hostile_names_ends() -> None:
    """Long names and a long pattern cannot make the search for a suggestion long."""
    assert suggest_pattern("_".join(["qqqqqqq"] * 30), ["z" * 500 + str(i) for i in range(5000)]) is None


def test_a_suggestion_can_be_matched_against_all_names() -> None:
    """A suggestion that only the first names can bear is none: callers match it without a guard."""
    # With `.*` behind it the pattern takes 63 761 steps a name (8 033 without), and all may take 5e7:
    # room for 784 names. The search itself looks at the first 512.
    pattern = "a{0,5}" * 4 + "_hip"
    name = "a" * 20 + "_hip" + "_joint" + "x" * 4
    assert suggest_pattern(pattern, [name] * 784) == f"{pattern}.*"
    assert suggest_pattern(pattern, [name] * 785) is None
    assert match_names(pattern, [name] * 785) == ()


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        pytest.param("fl_HIP_joint", "FL_hip_joint", id="a name"),
        pytest.param(".*_HIP_JOINT", ".*_hip_joint", id="small letters"),
        pytest.param("f[LR]_.*", "F[LR]_.*", id="capital letters"),
        pytest.param("F[LR]_HIP_.*", "F[LR]_hip_.*", id="one part of two"),
        pytest.param("(FL|FR)_.*_JOINT", "(FL|FR)_.*_joint", id="the last of three"),
        pytest.param(".*_HIPS_joint", None, id="a letter more"),
        pytest.param("hip", None, id="a part of a name"),
    ],
)
def test_other_letters(pattern: str, expected: str | None) -> None:
    """A pattern in the capital and small letters of the names, none with other letters."""
    assert recased(pattern, LEGS) == expected


def test_a_list_of_patterns_keeps_every_result_and_every_problem() -> None:
    """Union in the order of names, one entry a pattern, problems at their index."""
    found = resolve_patterns(["R._hip_joint", "*_hip_joint", ".*_claf_joint", "RR_.*", "wheel"], LEGS)
    rr = ("RR_hip_joint", "RR_thigh_joint", "RR_calf_joint")
    assert found.names == ("RL_hip_joint", *rr)
    assert found.by_pattern == (("RL_hip_joint", "RR_hip_joint"), (), (), rr, ())
    assert found.problems == (
        PatternProblem(
            1,
            "*_hip_joint",
            "'*_hip_joint' is not a regular expression: nothing to repeat at character 1",
            "patterns are regular expressions, not globs: write '.*_hip_joint'",
        ),
        PatternProblem(
            2,
            ".*_claf_joint",
            "pattern '.*_claf_joint' matches no joint",
            "did you mean '.*_calf_joint'?"
            " (matches FL_calf_joint, FR_calf_joint, RL_calf_joint, RR_calf_joint)",
        ),
        PatternProblem(
            4,
            "wheel",
            "pattern 'wheel' matches no joint",
            "the joints are: FL_hip_joint, FL_thigh_joint, FL_calf_joint, FR_hip_joint, FR_thigh_joint,"
            " FR_calf_joint, RL_hip_joint, RL_thigh_joint and 4 more",
        ),
    )


@pytest.mark.parametrize(
    ("patterns", "wanted", "expected"),
    [
        pytest.param([".*_hip_joint"], {n for n in LEGS if "hip" in n}, True, id="exact"),
        pytest.param(["F._hip_joint", "R._hip_joint"], {n for n in LEGS if "hip" in n}, True, id="union"),
        pytest.param(["F.*", "FL.*"], {n for n in LEGS if n[0] == "F"}, True, id="overlap"),
        pytest.param([".*"], {n for n in LEGS if "hip" in n}, False, id="too much"),
        pytest.param(["FL.*"], {n for n in LEGS if n[0] == "F"}, False, id="too little"),
        pytest.param([], set(), True, id="nothing"),
        pytest.param([".*_hip_joint"], {"FL_hip_joint", "wheel"}, False, id="unknown name wanted"),
    ],
)
def test_covering_is_exact(patterns: list[str], wanted: set[str], expected: bool) -> None:
    """A pattern may be emitted only where it selects the intended joints and no other."""
    assert covering_pattern(patterns, wanted, LEGS) is expected


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("joint[1-3]", ("joint1", "joint2", "joint3")),
        ("(left|right)_j[24]", ("left_j2", "left_j4", "right_j2", "right_j4")),
        ("hip(_joint)?", ("hip", "hip_joint")),
        ("hip", ("hip",)),
        pytest.param("joint[1-8]", tuple(f"joint{n}" for n in range(1, 9)), id="eight"),
        pytest.param("joint[1-9]", (), id="any digit"),
        pytest.param("[1-8][1-8][1-8]", (), id="512 names"),
        pytest.param("(?i)hip", (), id="in any letters"),
        *(
            pytest.param(text, (), id="any number")
            for text in (".*_hip", "joint.", r"joint\d", "[^a]b", "a+")
        ),
    ],
)
def test_names_that_a_pattern_writes_out(pattern: str, names: tuple[str, ...]) -> None:
    """By hand; each is a name that the pattern matches."""
    assert written_out(pattern) == names
    assert match_names(pattern, names) == names
