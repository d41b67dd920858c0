"""What an FMU of a block holds beside its code, whatever its flavour: description, page, terminals, icon; and its archive."""
