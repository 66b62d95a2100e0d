"""How Kalman filters fare where the state's noise is alpha-stable: `kalmanq study heavy-tails`.

    x[t+1] = a x[t] + w,   z[t] = c x[t] + v,   v Gaussian of variance R,   w and x[0] of S(alpha, beta, sigma),
    the filter being given the Gaussian of the same sigma, Q = 2 sigma^2.

After Mozgunov (2014).  settings.py says what is drawn, estimators.py what is made of it, claims.py what was said of
it and what came out.
"""
