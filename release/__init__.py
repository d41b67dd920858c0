"""Additions to a release's files: tested versions, software bills of materials, hashes. Not part of the wheel."""
