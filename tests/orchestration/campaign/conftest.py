"""The campaign of toy.py, for all tests of campaigns."""

from .toy import toy

__all__ = ["toy"]
