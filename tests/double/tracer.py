# SPDX-License-Identifier: GPL-3.0-or-later
"""A second renderer, small and slow: float64, every ray against every primitive, nothing taken from the core.

It knows Lambert reflection, mirrors, smooth dielectrics, emitting triangles; point, sun, rectangle and sphere lamps;
the local model and the rays of the classic methods; and paths in their plainest form: one direction by the material's
own density, lamps by a random point of their surface, no roulette and no weighing of techniques.

Rays are rows, (N, 3). Sources: Whitted 1980; Kajiya 1986; Snell's and Fresnel's laws (Born and Wolf, 1.5); the local
model as core/methods/local.py states it (Lafortune and Willems 1994).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

NEAR = 1e-9  # of the scene's extent; hits that are nearer belong to the surface that a ray leaves


@dataclass
class Material:
    """`kind` is "diffuse", "mirror" or "glass"; `gloss` is what the classic methods add to a diffuse one."""

    kind: str = "diffuse"
    color: tuple = (0.8, 0.8, 0.8)
    emission: tuple = (0.0, 0.0, 0.0)
    ior: float = 1.5
    gloss: float = 0.0


@dataclass
class Lamp:
    """`kind` is "point" (I, W/sr), "sun" (irradiance; `place` is where it stands), "sphere" or "area" (radiance)."""

    kind: str
    place: np.ndarray
    strength: np.ndarray
    radius: float = 0.0
    sides: np.ndarray | None = None  # (2, 3) of an area lamp, whose middle is `place`
    normal: np.ndarray | None = None

    @property
    def extended(self):
        return self.kind in ("sphere", "area")


@dataclass
class Hit:
    """What rays have met; `index` is -1 where nothing, `n` the normal on the viewer's side."""

    t: np.ndarray
    index: np.ndarray
    p: np.ndarray
    n: np.ndarray
    front: np.ndarray


@dataclass
class World:
    """Triangles (T, 3, 3) and their materials' numbers, spheres, planes, lamps, background."""

    triangles: np.ndarray
    material_of: np.ndarray
    materials: list
    lamps: list = field(default_factory=list)
    background: tuple = (0.0, 0.0, 0.0)
    spheres: list = field(default_factory=list)  # (centre, radius, material number)
    planes: list = field(default_factory=list)  # (point, normal, material number)

    def __post_init__(self):
        centers = [np.atleast_2d(c) for c, _, _ in self.spheres]
        points = np.concatenate([self.triangles.reshape(-1, 3), *centers, np.zeros((1, 3))])
        self.near = NEAR * max(1.0, float(np.abs(points).max()))
        numbers = [m for *_, m in self.spheres] + [m for *_, m in self.planes]
        self.owner = np.concatenate((self.material_of, np.array(numbers, int))).astype(int)

    # -- which primitive is met ----------------------------------------------------------------------------------------

    def intersect(self, o, d):
        """Nearest `Hit` of each ray."""
        best, index = np.full(len(o), np.inf), np.full(len(o), -1)
        for first, t in self._distances(o, d):
            own = t.argmin(axis=1)
            t = t[np.arange(len(o)), own]
            nearer = t < best
            best[nearer], index[nearer] = t[nearer], first + own[nearer]
        met = index >= 0
        p = o + np.where(met, best, 0.0)[:, None] * d
        n = self._normals(p, index)
        front = (n * d).sum(1) < 0
        return Hit(best, index, p, np.where(front[:, None], n, -n), front)

    def free(self, o, d, distance):
        """Whether nothing stands within `distance`."""
        free = np.ones(len(o), bool)
        for _, t in self._distances(o, d):
            free &= ~(t < distance[:, None] * (1 - 1e-9) - self.near).any(axis=1)
        return free

    def _distances(self, o, d):
        """(Number of the first, distances (N, K)) of triangles, spheres and planes; inf where they are missed."""
        count = len(self.triangles)
        if count:
            yield 0, self._triangle_distances(o, d)
        with np.errstate(all="ignore"):
            for number, (center, radius, _) in enumerate(self.spheres):
                to = o - center
                b, c = (to * d).sum(1), (to * to).sum(1) - radius * radius
                root = np.sqrt(b * b - c)
                t = np.where(-b - root > self.near, -b - root, -b + root)
                yield count + number, np.where(t > self.near, t, np.inf)[:, None]
            for number, (point, normal, _) in enumerate(self.planes):
                t = ((point - o) @ normal) / (d @ normal)
                yield count + len(self.spheres) + number, np.where(t > self.near, t, np.inf)[:, None]

    def _triangle_distances(self, o, d):
        """Each triangle's plane, then the signs of three areas within it."""
        a, b, c = self.triangles.transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        with np.errstate(all="ignore"):
            t = ((a * normal).sum(1) - o @ normal.T) / (d @ normal.T)
        inside = np.isfinite(t) & (t > self.near)
        ray, triangle = np.nonzero(inside)
        p = o[ray] + t[ray, triangle][:, None] * d[ray]
        ok = np.ones(len(ray), bool)
        for start, end in ((a, b), (b, c), (c, a)):
            side = np.cross((end - start)[triangle], p - start[triangle])
            ok &= (side * normal[triangle]).sum(1) >= 0
        inside[ray, triangle] = ok
        return np.where(inside, t, np.inf)

    def _normals(self, p, index):
        a, b, c = self.triangles.transpose(1, 0, 2)
        n, count = np.zeros_like(p), len(self.triangles)
        flat = (index >= 0) & (index < count)
        if flat.any():
            n[flat] = _unit(np.cross(b - a, c - a)[index[flat]])
        for number, (center, _, _) in enumerate(self.spheres, count):
            n[index == number] = _unit(p[index == number] - center)
        for number, (_, normal, _) in enumerate(self.planes, count + len(self.spheres)):
            n[index == number] = normal
        return n

    def columns(self, hit, name):
        """Property `name` of the materials that were met, a row each."""
        table = np.array([getattr(m, name) for m in self.materials], float)
        return table[self.owner[hit.index]]

    def kinds(self, hit):
        """Kind of material of each hit."""
        return np.array([m.kind for m in self.materials])[self.owner[hit.index]]

    # -- the classic methods -------------------------------------------------------------------------------------------

    def whitted(self, o, d, levels, ambient=None, exponent=None, reflectivity=None, shadows=True, least=1 / 1024):
        """Radiance of the classic methods: `levels` 1 is ray casting, without `shadows` Phong's model alone."""
        ambient = self.background if ambient is None else (ambient,) * 3
        options = (np.array(ambient), exponent, reflectivity, shadows, least)
        return self._whitted(o, d, np.ones((len(o), 3)), levels, options)

    def _whitted(self, o, d, weight, levels, options):
        if not len(o):
            return np.zeros((0, 3))
        ambient, exponent, reflectivity, shadows, least = options
        hit = self.intersect(o, d)
        out = np.tile(np.array(self.background, float), (len(o), 1))
        met = np.flatnonzero(hit.index >= 0)
        hit, d, weight = Hit(*(a[met] for a in vars(hit).values())), d[met], weight[met]
        if not len(met):
            return out
        color, kinds = self.columns(hit, "color"), self.kinds(hit)
        diffuse, specular, k_s, k_t, sharp, eta = self._phong(hit, d, color, kinds)
        sharp = sharp if exponent is None else np.full_like(sharp, exponent)
        k_s = k_s if reflectivity is None else np.full_like(k_s, reflectivity)
        mirror = d - 2 * (d * hit.n).sum(1)[:, None] * hit.n
        light = self.columns(hit, "emission") + diffuse * ambient
        for lamp in self.lamps:
            wi, distance, irradiance = _towards(lamp, hit.p)
            cosine = np.maximum((hit.n * wi).sum(1), 0)
            along = np.maximum((mirror * wi).sum(1), 0)
            lobe = (sharp + 2) / (2 * np.pi) * along**sharp
            seen = self.free(hit.p, wi, distance) if shadows else 1.0
            light += (diffuse / np.pi + specular * lobe[:, None]) * (cosine * seen)[:, None] * irradiance
        if levels > 1:
            bent, total = _bent(d, hit.n, eta)
            for wi, share in ((mirror, k_s + k_t * total[:, None]), (bent, k_t * ~total[:, None])):
                on = np.flatnonzero((share * weight).max(axis=1) > least)
                light[on] += share[on] * self._whitted(hit.p[on], wi[on], (share * weight)[on], levels - 1, options)
        out[met] = light
        return out

    def _phong(self, hit, d, color, kinds):
        """Diffuse, specular, k_s, k_t (N, 3), exponent, relative index (N,) of materials."""
        gloss = self.columns(hit, "gloss")[:, None]
        is_diffuse, is_mirror, is_glass = ((kinds == k)[:, None] for k in ("diffuse", "mirror", "glass"))
        ior = self.columns(hit, "ior")
        eta = np.where(hit.front, ior, 1 / ior)
        reflected = fresnel(-(d * hit.n).sum(1), eta)[:, None]
        diffuse = color * (1 - gloss) * is_diffuse
        specular = gloss * is_diffuse + color * is_mirror + color * reflected * is_glass
        k_s, k_t = specular * (1 - is_diffuse), color * (1 - reflected) * is_glass
        return diffuse, specular, k_s, k_t, np.full(len(d), 4096.0), np.where(is_glass[:, 0], eta, 1.0)

    # -- paths ---------------------------------------------------------------------------------------------------------

    def paths(self, o, d, depth, rng):
        """One path of at most `depth` scatterings for each ray: its radiance (N, 3)."""
        out, beta = np.zeros_like(o), np.ones_like(o)
        lane = np.arange(len(o))
        sees_lamps = np.zeros(len(o), bool)
        for bounce in range(depth + 1):
            hit = self.intersect(o, d)
            self._add_lamps(out, lane, beta, o, d, hit, sees_lamps)
            missed = hit.index < 0
            out[lane[missed]] += beta[missed] * self.background
            kept = ~missed
            hit, d, beta, lane = Hit(*(a[kept] for a in vars(hit).values())), d[kept], beta[kept], lane[kept]
            if not len(lane):
                break
            out[lane] += beta * self.columns(hit, "emission")
            if bounce == depth:
                break
            color, diffuse = self.columns(hit, "color"), self.kinds(hit) == "diffuse"
            for lamp in self.lamps:
                wi, distance, light = _random_light(lamp, hit.p, rng)
                cosine = np.maximum((hit.n * wi).sum(1), 0) * self.free(hit.p, wi, distance) * diffuse
                out[lane] += beta * color / np.pi * light * cosine[:, None]
            o, d, beta, sees_lamps = hit.p, self._scattered(hit, d, rng), beta * color, ~diffuse
        return out

    def _add_lamps(self, out, lane, beta, o, d, hit, sees):
        """Lamps with an extent that rays of mirrors and glass cross."""
        for lamp in self.lamps:
            if lamp.extended and sees.any():
                t = _crossing(lamp, o, d)
                crossed = sees & (t > self.near) & (t < hit.t)
                out[lane[crossed]] += beta[crossed] * lamp.strength

    def _scattered(self, hit, d, rng):
        kinds = self.kinds(hit)
        mirror = d - 2 * (d * hit.n).sum(1)[:, None] * hit.n
        sphere = _unit(rng.normal(size=d.shape))
        lambert = _unit(hit.n + sphere * (1 - 1e-12))  # a sphere on the surface: the cosine's own density
        ior = self.columns(hit, "ior")
        eta = np.where(hit.front, ior, 1 / ior)
        bent, total = _bent(d, hit.n, eta)
        reflects = total | (rng.random(len(d)) < fresnel(-(d * hit.n).sum(1), eta))
        glass = np.where(reflects[:, None], mirror, bent)
        return np.select([(kinds == k)[:, None] for k in ("diffuse", "mirror")], [lambert, mirror], glass)


def fresnel(cosine, eta):
    """Reflectance of unpolarised light, by the angles."""
    sine = np.sqrt(np.maximum(1 - cosine**2, 0)) / eta
    with np.errstate(all="ignore"):
        t = np.sqrt(1 - sine**2)
        s, p = (cosine - eta * t) / (cosine + eta * t), (eta * cosine - t) / (eta * cosine + t)
        return np.where(sine >= 1, 1.0, 0.5 * (s * s + p * p))


def _bent(d, n, eta):
    """Snell's direction, and where all is reflected."""
    cosine = -(d * n).sum(1)
    under = 1 - (1 - cosine**2) / eta**2
    wi = d / eta[:, None] + n * (cosine / eta - np.sqrt(np.maximum(under, 0)))[:, None]
    return _unit(wi), under < 0


def _towards(lamp, p):
    """Direction, distance and irradiance on a facing surface, of the classic methods' lamps: points and suns."""
    if lamp.kind == "sun":
        wi = np.broadcast_to(lamp.place / np.linalg.norm(lamp.place), p.shape)
        return wi, np.full(len(p), np.inf), np.broadcast_to(lamp.strength, p.shape)
    to = lamp.place - p
    distance = np.linalg.norm(to, axis=1)
    return to / distance[:, None], distance, lamp.strength / distance[:, None] ** 2


def _random_light(lamp, p, rng):
    """Direction, distance and the weight of what a random point of a lamp sends."""
    if not lamp.extended:
        return _towards(lamp, p)
    if lamp.kind == "area":
        u = rng.random((2, len(p), 1)) - 0.5
        point = lamp.place + u[0] * lamp.sides[0] + u[1] * lamp.sides[1]
        normal, area = lamp.normal, np.linalg.norm(np.cross(*lamp.sides))
    else:
        normal = _unit(rng.normal(size=p.shape))
        point, area = lamp.place + lamp.radius * normal, 4 * np.pi * lamp.radius**2
    to = point - p
    distance = np.linalg.norm(to, axis=1)
    wi = to / distance[:, None]
    facing = np.maximum(-(wi * normal).sum(1), 0)
    return wi, distance, lamp.strength * (facing * area / distance**2)[:, None]


def _crossing(lamp, o, d):
    """Distance at which rays cross a lamp on the side that shines; inf where they do not."""
    with np.errstate(all="ignore"):
        if lamp.kind == "sphere":
            to = o - lamp.place
            b = (to * d).sum(1)
            t = -b - np.sqrt(b * b - (to * to).sum(1) + lamp.radius**2)
            return np.where(np.isfinite(t), t, np.inf)
        t = ((lamp.place - o) @ lamp.normal) / (d @ lamp.normal)
        across = o + t[:, None] * d - lamp.place
        inside = (d @ lamp.normal) < 0
        for side in lamp.sides:
            inside &= np.abs(across @ side) <= 0.5 * (side @ side)
        return np.where(inside, t, np.inf)


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
