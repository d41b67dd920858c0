"""How stable a loop is: margins by injected signals, linear models, and the change that loses it."""
