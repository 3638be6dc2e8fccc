"""The speed of the domino effect (van Leeuwen, The domino effect, Am. J. Phys. 78, 721, 2010): dominoes turn about their lower front edge
without slip, blows are inelastic, and each that has fallen leans on the next without friction. Lengths over the height of a domino."""
import math


class Row:
    """Dominoes of unit height and mass, of some thickness, with gaps between them."""

    def __init__(self, thickness, gap, gravity):
        self.d, self.s, self.g = thickness, gap, gravity
        self.inertia = (1 + thickness**2) / 3
        self.touch = math.asin(gap)  # tilt at which a domino meets the next, which stands

    def behind(self, tilt):
        """Tilt of the one that leans on a domino: sin(θ' − θ) = (s + d) cos θ − d."""
        return tilt + math.asin((self.s + self.d) * math.cos(tilt) - self.d)

    def rate(self, tilt):
        """dθ'/dθ."""
        x = (self.s + self.d) * math.cos(tilt) - self.d
        return 1 - (self.s + self.d) * math.sin(tilt) / math.sqrt(1 - x * x)

    def train(self, tilt, count):
        """Inertia of all that move, over that of one, and their potential energy, by the tilt of the foremost."""
        inertia = potential = 0.0
        share = 1.0
        for _ in range(count):
            inertia += share * share
            potential += 0.5 * self.g * (math.cos(tilt) + self.d * math.sin(tilt))
            share *= self.rate(tilt)
            tilt = self.behind(tilt)
        return inertia, potential

    def times(self, count, spin, pieces=400):
        """[s] at which each domino is hit, the first set going with a spin, [rad/s]; by Simpson's rule between blows."""
        hits = [0.0]
        for moving in range(1, count):
            inertia, potential = self.train(0.0, moving)
            energy = 0.5 * self.inertia * inertia * spin**2 + potential

            def slowness(tilt):
                j, v = self.train(tilt, moving)
                return math.sqrt(0.5 * self.inertia * j / (energy - v))

            step = self.touch / pieces
            sides = slowness(0.0) + slowness(self.touch)
            inner = sum((4 if i % 2 else 2) * slowness(i * step) for i in range(1, pieces))
            hits.append(hits[-1] + step / 3 * (sides + inner))
            j, _ = self.train(self.touch, moving)
            spin = j / (j + 1) / slowness(self.touch)  # angular momentum about both edges: J ω = (J + 1) ω'
        return hits
