"""Laws in Python files to compare with, and to begin from: each flies as `python: FILE` in the controller's place."""
