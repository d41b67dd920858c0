"""The commands of `python -m evidence`."""

import pytest
from click.testing import CliRunner

from evidence.__main__ import main


@pytest.mark.parametrize("command", [[], *([name] for name in sorted(main.commands))])
def test_every_command_has_a_short_option_for_its_help(command):
    short, long = (CliRunner().invoke(main, [*command, option]) for option in ("-h", "--help"))
    assert (short.exit_code, short.output) == (0, long.output)
