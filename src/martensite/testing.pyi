from martensite_testing import *
