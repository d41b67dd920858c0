"""The contents of an FMU beside its code, whatever its flavour: description, page, terminals, icon; and its archive."""
