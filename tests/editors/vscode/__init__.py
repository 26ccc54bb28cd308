"""VS Code's part of the tests of editors."""
