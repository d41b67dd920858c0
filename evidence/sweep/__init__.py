"""What each constant of the planned controller is worth: tumbles with half and twice its value."""
