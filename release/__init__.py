"""What a release carries besides its files: tested versions, software bills of materials, hashes. Not part of the wheel."""
