"""What a run gives: the Result, its folder, figures and report page."""
