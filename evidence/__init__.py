"""Studies of the loop, one folder or module a study; `python -m evidence --help` lists them.

They run the native FMUs through `orchestration` or call the blocks' own functions; nothing in the product imports them.
"""
