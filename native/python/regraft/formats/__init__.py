"""Files the command writes: images, movies, JSON lines, all or nothing."""
