"""The command ``armsyn``: one file a command, imported when it is called."""
