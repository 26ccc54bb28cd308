"""What the command line and the server share and neither is."""
