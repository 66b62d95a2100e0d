"""An epidemic: shares of the susceptible and the infected (logit of the latter), and its contact rate; daily tests"""
import numpy as np

states = ["susceptible", "logit infected", "log contact", "recovered"]
measurements = {"names": ["positive share", "antibodies"], "units": ["%", "%"]}
x0, P0 = [0.95, -4.0, -1.2, 0.03], [1e-4, 0.25, 0.04, 1e-4]
Q, R = [1e-10, 1e-4, 1e-4, 1e-10], [0.01, 0.25]


def f(x):
    s, logit, beta, r = x
    i = 1 / (1 + np.exp(-logit))
    new, gone, lost = np.exp(beta) * s * i, 0.1 * i, 0.02 * r
    return s - new + lost, logit + (new - gone) / (i * (1 - i)), -1.2 + 0.99 * (beta + 1.2), r + gone - lost


def h(x):
    return 100 / (1 + np.exp(-x[1])), 100 * x[3]
