from martensite.physics.laws.brinson import Brinson as Brinson
from martensite.physics.laws.lagoudas import Lagoudas as Lagoudas
from martensite.physics.laws.mas import MullerAchenbachSeelecke as MullerAchenbachSeelecke
from martensite.physics.laws.mas_hybrid import MullerAchenbachSeeleckeHybrid as MullerAchenbachSeeleckeHybrid
from martensite.physics.laws.mas_polycrystal import (
    MullerAchenbachSeeleckePolycrystal as MullerAchenbachSeeleckePolycrystal,
)
from martensite.physics.laws.r_phase import RPhase as RPhase
from martensite.physics.laws.strip_laws import Elahinia as Elahinia
from martensite.physics.laws.strip_laws import LiangRogers as LiangRogers
from martensite.physics.laws.strip_laws import Tanaka as Tanaka
