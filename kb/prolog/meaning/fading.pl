:- module(facetlog_fading, [ membership_within/3,  % +Margins, +Width, -Degree
                             mass/3                % +Mean, +Variance, -Mass
                           ]).

/** <module> Edges of regions, sharp and fading

A region's edge is sharp, or its membership falls linearly from 1 to 0 over some width, about the limit
or beyond it. The degree is the expected membership of the true value, normally distributed about the
measured one. Margins are those of compare.pl.
*/

:- set_prolog_flag(optimise, true).

%!  membership_within(+Margins, +Width, -Degree) is det.
%
%   Degree is the expected membership of a region with these Margins, measured from the middle of its
%   slopes. Where one slope is below 1 the other is 1, so that memberships add as masses do.

membership_within(one(_, D, V), Width, Degree) :-
    expected(D, V, Width, Membership),
    Degree is max(0.0, min(1.0, Membership)).
membership_within(two(B, BV, A, AV), Width, Degree) :-
    expected(B, BV, Width, FromBelow),
    expected(A, AV, Width, FromAbove),
    Degree is max(0.0, min(1.0, FromBelow + FromAbove - 1)).

%   Of a slope that is narrower than this many deviations only the middle counts: the mean of the
%   normal distribution function over it is that within 1/24 of the square of this.
narrow(1.0e-4).

%   What is so many deviations beyond a slope is on its level side: less than 1.0e-16 of the mass is not.
far(9).

%   Expected value of clip(1/2 + X/Width, 0, 1) for a normal X of this mean and variance. With
%   E max(0, X) = max(0, Mean) + Sd g(|Mean|/Sd) it is a difference of two such terms.
expected(Mean, Var, Width, Membership) :-
    far(Far),
    Low is Mean - Width/2,
    (   Low >= 0,
        Low*Low >= Far*Far*Var
    ->  Membership = 1.0
    ;   High is Mean + Width/2,
        (   High =< 0,
            High*High >= Far*Far*Var
        ->  Membership = 0.0
        ;   on_or_near(Low, High, Mean, Var, Width, Membership)
        )
    ).

on_or_near(Low, High, Mean, Var, Width, Membership) :-
    Sd is sqrt(Var),
    narrow(Narrow),
    (   Width =< Narrow*Sd
    ->  mass(Mean, Var, Membership)
    ;   on_slope(Low, High, Mean, Width, At),
        (   Sd > 0
        ->  FromHigh is abs(High)/Sd,
            FromLow is abs(Low)/Sd,
            loss(FromHigh, Above),
            loss(FromLow, Below),
            Membership is At + Sd/Width*(Above - Below)
        ;   Membership = At
        )
    ).

%   The membership at the mean itself.
on_slope(Low, High, Mean, Width, At) :-
    (   Low >= 0
    ->  At = 1
    ;   High =< 0
    ->  At = 0
    ;   At is 0.5 + Mean/Width
    ).

%   g(T) = phi(T) - T Phi(-T), of the standard normal distribution.
loss(T, Loss) :-
    (   negligible(Far),
        T > Far
    ->  Loss = 0
    ;   Loss is exp(-T*T/2)/sqrt(2*pi) - T*0.5*erfc(T/sqrt(2))
    ).

%   In deviations: the density beyond is less than the least float.
negligible(40).

%!  mass(+Mean, +Variance, -Mass) is det.
%
%   Probability that a normal variable of this mean and variance is not negative.

mass(Mean, Var, Mass) :-
    (   Var > 0
    ->  Mass is 0.5*erfc(-Mean/sqrt(2*Var))
    ;   Mean >= 0
    ->  Mass = 1.0
    ;   Mass = 0.0
    ).
