"""Bergman's minimal model: glucose, insulin's remote effect, insulin; a sensor each minute"""
states = {"names": ["glucose", "effect", "insulin"], "units": ["mg/dl", "1/min", "mU/l"]}
measurements = {"names": ["sensor"], "units": ["mg/dl"]}
controls = {"names": ["meal", "pump"], "units": ["mg/dl/min", "mU/l/min"], "ranges": [50, 50]}
x0, P0, Q, R = [110, 0.001, 12], [400, 1e-6, 16], [1, 1e-9, 0.01], 25


def increment(x, t, u):
    g, e, i = x
    return [-(0.015 + e) * g + 0.015 * 95 + u[0], -0.025 * e + 1.3e-5 * (i - 7), -0.09 * (i - 7) + u[1] + 0.003 * max(g - 90, 0)]


def h(x):
    return [x[0]]


def simulated_controls(t):
    return (4.0 if t % 300 < 30 else 0.0, 1.0 if t % 300 < 60 else 0.2)
