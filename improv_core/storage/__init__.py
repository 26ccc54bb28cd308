"""What the command line and the language server share."""
