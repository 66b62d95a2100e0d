# The module in MicroPython: numbers as bits, refusals, and objects that outlive collections.  Numbers are
# fractions of powers of two: MicroPython 1.9 rounds decimals more than once.
import gc
import kalmanq
import ustruct as struct


def bits(numbers):
    return " ".join(["".join(["%02x" % byte for byte in struct.pack(">f", x)]) for x in numbers])


def refused(call, *arguments):
    try:
        call(*arguments)
    except (ValueError, TypeError) as problem:
        print(repr(problem))
        return
    raise RuntimeError("it is not refused")


def made():
    process = kalmanq.Process([[1, 1 / 8], [0, 15 / 16]], [[1 / 32, 1 / 64], [1 / 64, 1 / 16]], [[1 / 128], [1 / 8]])
    sensor = kalmanq.Sensor([[1, 0], [1 / 2, 1]], [[1 / 2, 1 / 8], [1 / 8, 1 / 4]])
    return process, sensor, kalmanq.Filter([1, -1], [[2, 1 / 2], [1 / 2, 3]])


process, sensor, f = made()
gc.collect()
for k in range(100):
    z = (k * 37 % 11) / 8
    junk = [[float(i)] * 20 for i in range(30)]  # what is not kept is overwritten
    if k % 5 == 3:
        f.predict(process, [1 / 4])
        f.update(sensor, [None, z])
    else:
        f.step(process, sensor, [z, -z], [1 / 4])
    gc.collect()
print("f32", bits(f.mean()), bits(f.sigma()), f.events())
before = bits(f.mean()), bits(f.covariance()[0]), bits(f.covariance()[1])
refused(f.update, sensor, [float("nan"), 0])
refused(f.update, sensor, [1])
refused(f.update, process, [1, 2])
refused(f.step, process, sensor, [1, 2], [1, 2])
refused(kalmanq.Filter, [0, 0], [[1, 2], [2, 1]])
refused(kalmanq.Filter, [0, 0], [[1, 0]])
refused(kalmanq.Filter, [0] * 17, [[1]])
refused(kalmanq.Process, [], [])
refused(kalmanq.Sensor, [[1]], [[1, 2]])
assert before == (bits(f.mean()), bits(f.covariance()[0]), bits(f.covariance()[1]))
exact, one = kalmanq.Sensor([[1]], [[0]]), kalmanq.Filter([0], [[1]])
one.update(exact, [0.5])
one.update(exact, [0.5])
print("events", one.events(), one.events())
print("done")
