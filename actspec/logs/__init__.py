"""Recordings of a robot's joints: CSV, NPZ or Parquet, with a sidecar that says how they were made.

    log = load_log("hip.csv")       # and hip.yaml beside it
    log.joints["hip"].position      # rad, shape (n,)

One format for identification, networks and reports. Nothing in a log is executed: pickles are refused.
"""

from __future__ import annotations

from actspec.logs.log import BASE, SIGNALS, BaseLog, JointLog, Log, LogError
from actspec.logs.read import load_log
from actspec.logs.sidecar import check_results_path
from actspec.logs.write import check_log_path, write_log
from actspec.spec.sidecar import Sidecar

__all__ = [
    "BASE",
    "SIGNALS",
    "BaseLog",
    "JointLog",
    "Log",
    "LogError",
    "Sidecar",
    "check_log_path",
    "check_results_path",
    "load_log",
    "write_log",
]
