from counted import Counted
def count(*_): raise NotImplementedError
