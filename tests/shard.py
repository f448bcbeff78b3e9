# SPDX-License-Identifier: GPL-2.0-or-later
"""A plugin of pytest for scripts/test.sh: a line per test as GoogleTest writes it, so that one runner counts both."""

import pytest

@pytest.hookimpl(tryfirst=True)
def pytest_report_teststatus(report):
    return report.outcome if report.when == "call" or not report.passed else "", "", ""


class _Lines:
    def __init__(self, terminal) -> None:
        self.terminal, self.state, self.seconds = terminal, "passed", 0.0

    def pytest_runtest_logreport(self, report) -> None:
        """A test has failed if any of its three phases has; its line comes with the last one."""
        if report.when == "setup":
            self.state, self.seconds = "passed", 0.0
        if report.skipped:
            file, line, reason = report.longrepr
            self.terminal.write_line(f"{file}:{line}: Skipped\n{reason.removeprefix('Skipped: ')}")
        self.state = report.outcome if self.state == "passed" else self.state
        self.seconds += report.duration
        if report.when == "teardown":
            mark = {"passed": "       OK ", "failed": "  FAILED  ", "skipped": "  SKIPPED "}[self.state]
            self.terminal.write_line(f"[{mark}] {report.nodeid.replace(' ', '_')} ({self.seconds * 1e3:.0f} ms)")


@pytest.hookimpl(trylast=True)
def pytest_configure(config) -> None:
    config.pluginmanager.register(_Lines(config.pluginmanager.getplugin("terminalreporter")))
