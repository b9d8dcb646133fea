"""PNG: each picture is a function of what it shows and the folder to write it in."""
