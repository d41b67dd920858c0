"""Campaigns: a scenario flown again and again with values that vary, and requirements decided by the share of runs that
meet them.
"""
