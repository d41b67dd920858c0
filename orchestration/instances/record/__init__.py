"""Records the calls of an instance of an FMU, and gives who made it a program that plays them."""
