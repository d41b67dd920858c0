"""Studies of the loop, one folder a study: `reproduction`, `flight`, `allocators`; and the momentum bound.

They run the native FMUs through `orchestration` or call the blocks' own functions; nothing in the product imports them.
"""
