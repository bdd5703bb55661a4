from martensite_export import *
