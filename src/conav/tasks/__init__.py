"""What a robot is to do, in finite linear temporal logic over the names of regions."""
