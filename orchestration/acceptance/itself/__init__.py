"""Judges a block by itself, where ours gives no same answer to stand against: by what any right block has to keep."""
