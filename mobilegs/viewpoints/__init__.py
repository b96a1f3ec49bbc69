"""Choice of viewpoints: first views and limits, placed cameras, and cameras between others."""
