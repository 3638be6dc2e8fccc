"""Figures of time series."""
import numpy as np


def slope_of(t, x):
    """Least-squares slope of x over t."""
    return float(np.polyfit(t, x, 1)[0])


def acceleration(t, speed, start=0.0, end=np.inf):
    """Slope of a speed within a window of time."""
    window = (t >= start) & (t <= end)
    return slope_of(t[window], speed[window])


def order(steps, errors):
    """p of error ~ step^p by least squares over the logarithms; nothing where an error is zero or there are too few."""
    if len(steps) < 2 or min(abs(e) for e in errors) == 0.0:
        return None
    return slope_of(np.log(steps), np.log(np.abs(errors)))


def period(t, x):
    """Mean time between rising passages through the mean of x."""
    y = x - 0.5 * (x.min() + x.max())
    rising = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    crossings = t[rising] - y[rising] * (t[rising + 1] - t[rising]) / (y[rising + 1] - y[rising])
    return float(np.mean(np.diff(crossings)))


def mean_spin(x, v):
    """[rad/s] the turn that fits the velocities of points best. x, v of shape (n, 3)"""
    d, u = x - x.mean(0), v - v.mean(0)
    inertia = (d**2).sum() * np.eye(3) - d.T @ d
    return np.linalg.pinv(inertia) @ np.cross(d, u).sum(0)
