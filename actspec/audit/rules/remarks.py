"""ACT: the remarks in audited files that set findings aside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.diagnostics import Severity


class _RemarkRule(Rule):
    """A rule over remarks: the engine judges them, after all other rules have run."""

    severity: ClassVar[Severity] = Severity.WARNING
    confidence: ClassVar[Confidence] = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Nothing; whether a remark was of use is known only when all rules have run."""
        return iter(())


class IgnoreWithoutReason(_RemarkRule):
    """A remark sets a finding aside and does not say why.

    ## What it does
    Reports `actspec: ignore[CODE]` without a reason. Such a remark is not followed.

    ## Why it matters
    A figure that looks wrong and is right has a reason. Whoever meets the remark a year later, with another motor
    in the joint, cannot tell whether it still holds.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee"/>  <!-- actspec: ignore[LIM101] -->
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee"/>  <!-- actspec: ignore[LIM101] the driver clips at 33.5 N*m -->
      </actuator>
    </mujoco>
    ```

    ## Source
    Chosen: a remark without a reason cannot be reviewed.
    """

    code = "ACT001"
    name = "ignore-without-reason"


class UnusedIgnore(_RemarkRule):
    """A remark sets nothing aside.

    ## What it does
    Reports the codes of an `actspec: ignore[...]` that no finding belongs to, if their rule has run and had input, in
    this run and with fewer of the files: a hook that sees one file and a run over the folder do not contradict each
    other. A remark speaks about its own line, or, alone on a line, about the next one (in XML: the next start tag);
    `ignore-file` speaks about the whole file and stands in its first ten lines.

    ## Why it matters
    The fault that it excused has been mended, or the remark stands in the wrong place. Left there, it will hide the
    next fault on that line.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <!-- actspec: ignore[LIM101] the driver clips at 33.5 N*m -->
        <motor joint="knee" forcerange="-33.5 33.5" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" forcerange="-33.5 33.5" forcelimited="true"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Not judged: remarks on rules that this run does not select, or that had no input. Remarks on rules that compare
    files, and all of a configuration, are judged where a folder was named, which is taken for all files of its robots;
    then the file alone, with each other one of its robot, with all, and with all but one are looked at.

    ## Source
    Chosen: as other checkers of source text do.
    """

    code = "ACT002"
    name = "unused-ignore"


class UnknownIgnore(_RemarkRule):
    """A remark names a rule that is not there.

    ## What it does
    Reports `actspec: ignore[...]` with a code or name that no rule has, or without any. The full code or the full
    name is needed: a family such as `LIM` belongs in the settings.

    ## Why it matters
    The remark is not followed, and its author believes that it is.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee"/>  <!-- actspec: ignore[LIN101] the driver clips at 33.5 N*m -->
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee"/>  <!-- actspec: ignore[LIM101] the driver clips at 33.5 N*m -->
      </actuator>
    </mujoco>
    ```

    ## Source
    Chosen: a misspelt code must not hide or keep a finding by accident.
    """

    code = "ACT003"
    name = "unknown-ignore"


RULES: tuple[type[Rule], ...] = (IgnoreWithoutReason, UnusedIgnore, UnknownIgnore)
