"""Studies of the loop: what the paper's claims depend on, what conservation allows, whence the law converges.

They call the blocks' own functions, or run FMUs through `orchestration`; nothing in the product imports them.
"""
