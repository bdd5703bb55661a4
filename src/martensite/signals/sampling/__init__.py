"""Records at equal intervals: conversion from tables, resampling, detrending."""
