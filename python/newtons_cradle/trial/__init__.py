"""Hosts on trial: small cases with a known answer, and a judge that says what a tool did wrong in them."""

from .cases import CASES, Case
from .judge import judge, judge_all, write_cases

__all__ = ["CASES", "Case", "judge", "judge_all", "write_cases"]
