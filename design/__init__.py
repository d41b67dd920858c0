"""Computes what a satellite needs before it flies: gains for a wished time, and the least time of a manoeuvre.

It knows the paper's three blocks and reads scenarios by `orchestration`; its commands are entry points
(pyproject.toml).
"""
