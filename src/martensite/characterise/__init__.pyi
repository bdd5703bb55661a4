from martensite.characterise.estimate import MeasuredValue as MeasuredValue
from martensite.characterise.film_coefficient import FilmFit as FilmFit
from martensite.characterise.film_coefficient import film_r_squared as film_r_squared
from martensite.characterise.film_coefficient import fit_film as fit_film
from martensite.characterise.film_points import FilmPoints as FilmPoints
from martensite.characterise.film_points import points_from_power as points_from_power
from martensite.characterise.film_report import FilmReport as FilmReport
from martensite.characterise.film_report import judge_film as judge_film
from martensite.characterise.free_vibration import LogDecrement as LogDecrement
from martensite.characterise.free_vibration import frequency_of as frequency_of
from martensite.characterise.free_vibration import log_decrement as log_decrement
from martensite.characterise.free_vibration import moving_mass as moving_mass
from martensite.characterise.motor_constants import MotorConstants as MotorConstants
from martensite.characterise.motor_constants import (
    estimate_motor_constants as estimate_motor_constants,
)
from martensite.characterise.motor_tests import steady_running as steady_running
from martensite.characterise.motor_tests import winding_resistance as winding_resistance
from martensite.characterise.moving_average import average_moving as average_moving
from martensite.characterise.moving_average import moving_average_gain as moving_average_gain
from martensite.characterise.spectrum import SpectralPeak as SpectralPeak
from martensite.characterise.spectrum import natural_frequency as natural_frequency
from martensite.characterise.tangent_fit import TangentFit as TangentFit
from martensite.characterise.tangent_fit import fit_tangents as fit_tangents
from martensite.characterise.tangent_points import TangentPoints as TangentPoints
from martensite.characterise.tangent_points import find_tangent_points as find_tangent_points
from martensite.characterise.time_constant import Rise as Rise
from martensite.characterise.time_constant import fit_rise as fit_rise
