"""Unit quaternions w, x, y, z, for model files"""
import numpy as np


def product(p, q):
    w, v = p[0] * q[0] - np.dot(p[1:], q[1:]), p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.concatenate([[w], v])


def conjugate(q):
    return np.concatenate([q[:1], -q[1:]])


def turned(q, v):
    """q and then a rotation by the vector v, in the body's axes"""
    half = v / 2
    angle = np.sqrt(np.dot(half, half))
    cosine, share = (np.cos(angle), np.sin(angle) / angle) if angle > 1e-5 else (1.0, 1.0)
    made = product(q, np.concatenate([[cosine], share * half]))
    return made / np.sqrt(np.dot(made, made))


def between(a, b):
    """The small rotation that leads from b to a"""
    return 2 * product(conjugate(b), a)[1:]


def to_world(q, v):
    t = 2 * np.cross(q[1:], v)
    return v + q[0] * t + np.cross(q[1:], t)


def to_body(q, v):
    return to_world(conjugate(q), v)
