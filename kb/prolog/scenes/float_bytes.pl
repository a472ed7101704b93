:- module(facetlog_float_bytes, [ floats_bytes/2,       % +Floats, -Bytes
                                  bytes_floats/3,       % +Count, +Bytes, -Floats
                                  bytes_compound/3      % +Count, +Bytes, -Compound
                                ]).

/** <module> Floats as bytes

Nine bytes for each float: a byte that Prolog wants to see, and the eight of the float as IEEE 754
has them, the least significant first. That is how fast_term_serialized/2 writes the arguments of a
compound, after a head that depends on their number. Whether this version of SWI-Prolog does so is
found when this file is loaded; if not, writing fails and reading is done by arithmetic.
*/

:- use_module(library(lists)).

float_byte(14).

%   The head is what is left of the whole without the nine bytes of each.
layout_known :-
    fast_term_serialized(floats(1.0, -0.0, -2.5), Text),
    string_codes(Text, Codes),
    float_byte(Byte),
    append(_, [ Byte, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f,
                Byte, 0, 0, 0, 0, 0, 0, 0, 0x80,
                Byte, 0, 0, 0, 0, 0, 0, 0x04, 0xc0 ], Codes),
    !.

%!  floats_bytes(+Floats, -Bytes) is semidet.
%
%   Bytes is a string that *ends* in nine bytes for each of Floats. Fails if this version of
%   SWI-Prolog has another layout.

%!  bytes_floats(+Count, +Bytes, -Floats) is det.
%!  bytes_compound(+Count, +Bytes, -Compound) is det.
%
%   Floats are the Count floats of which Bytes has nine bytes each; Compound has them as arguments.

:- if(layout_known).

floats_bytes(Floats, Bytes) :-
    compound_name_arguments(Compound, floats, Floats),
    fast_term_serialized(Compound, Bytes).

bytes_floats(Count, Bytes, Floats) :-
    bytes_compound(Count, Bytes, Compound),
    compound_name_arguments(Compound, _, Floats).

bytes_compound(Count, Bytes, Compound) :-
    head(Count, Head),
    string_concat(Head, Bytes, Text),
    fast_term_serialized(Compound, Text).

:- dynamic known_head/2.                % Count, Head

%   Found of zeros, and remembered where that may come again.
head(Count, Head) :-
    known_head(Count, Head0),
    !,
    Head = Head0.
head(Count, Head) :-
    length(Zeros, Count),
    zeros(Zeros),
    floats_bytes(Zeros, Model),
    Tail is 9*Count,
    sub_string(Model, 0, _, Tail, Head),
    most_known(Most),
    ( Count =< Most -> assertz(known_head(Count, Head)) ; true ).

most_known(5000).       % heads of 15 characters

zeros([]).
zeros([0.0|Zeros]) :- zeros(Zeros).

:- else.

floats_bytes(_, _) :- fail.

bytes_floats(_, Bytes, Floats) :-
    string_codes(Bytes, Codes),
    worked_out(Codes, Floats).

bytes_compound(Count, Bytes, Compound) :-
    bytes_floats(Count, Bytes, Floats),
    compound_name_arguments(Compound, floats, Floats).

:- endif.

%   Without fast_term_serialized/2: sign, exponent and mantissa.
worked_out([], []).
worked_out([_, A, B, C, D, E, F, G, H|Codes], [Float|Floats]) :-
    Bits is A \/ B<<8 \/ C<<16 \/ D<<24 \/ E<<32 \/ F<<40 \/ G<<48 \/ H<<56,
    Exponent is (Bits >> 52) /\ 0x7ff,
    Mantissa is Bits /\ 0xfffffffffffff,
    (   Exponent =:= 0
    ->  Size is Mantissa * 2.0 ** -1074
    ;   Size is (Mantissa + 0x10000000000000) * 2.0 ** (Exponent - 1075)
    ),
    (   Bits >= 0x8000000000000000
    ->  Float is -Size
    ;   Float = Size
    ),
    worked_out(Codes, Floats).
