:- module(facetlog_foreign_signs, [ foreign_sign/2,      % +Text, -Fault
                                    sign_advice/2,       % +Sign, -Advice
                                    metres_of/2          % ?Unit, ?Metres
                                  ]).

/** <module> Signs of other languages in a question, and what to write in their place */

:- use_module(library(lists)).
:- use_module(library(apply)).

%!  sign_advice(+Sign, -Advice) is semidet.
%
%   Sign is an atom that other languages have; Advice says what is written here.

sign_advice('!=',  "write X =\\= Y of numbers, X \\== Y of names").
sign_advice('<>',  "write X =\\= Y of numbers, X \\== Y of names").
sign_advice('≠',   "write X =\\= Y of numbers, X \\== Y of names").
sign_advice('<=',  "write X =< Y").
sign_advice('≤',   "write X =< Y").
sign_advice('=>',  "write X >= Y").
sign_advice('≥',   "write X >= Y").
sign_advice('&&',  "write a comma for \"and\"").
sign_advice('&',   "write a comma for \"and\"").
sign_advice(and,   "write a comma for \"and\"").
sign_advice('||',  "write a semicolon for \"or\", with both goals in parentheses: (A ; B)").
sign_advice(or,    "write a semicolon for \"or\", with both goals in parentheses: (A ; B)").
sign_advice('∧',   "write a comma for \"and\"").
sign_advice('|',   "write a semicolon for \"or\", with both goals in parentheses: (A ; B)").
sign_advice('∨',   "write a semicolon for \"or\", with both goals in parentheses: (A ; B)").
sign_advice('¬',   "write \\+ before a goal for \"there is no\"").
sign_advice('~',   "write \\+ before a goal for \"there is no\"").
sign_advice('===', "write X =:= Y of numbers, X == Y of names").
sign_advice('!==', "write X =\\= Y of numbers, X \\== Y of names").
sign_advice('°',   "angles in goals are in degrees: write the number alone").
sign_advice('!',   "write \\+ before a goal for \"there is no\"").
sign_advice(not,   "write \\+ before a goal for \"there is no\"").
sign_advice(in,    "write member(X, [a, b])").
sign_advice(between, "write X >= Low, X =< High").
sign_advice('×',   "write X * Y").
sign_advice('·',   "write X * Y").
sign_advice('−',   "write a plain minus sign: -").
sign_advice(Quote, "write names without quotation marks: box") :-
    memberchk(Quote, ['‘', '’', '‚', '“', '”', '„', '«', '»', '´']).

%!  metres_of(?Unit, ?Metres) is nondet.

metres_of(mm, 0.001).
metres_of(cm, 0.01).
metres_of(dm, 0.1).
metres_of(m, 1).
metres_of(inch, 0.0254).
metres_of(ft, 0.3048).

%!  foreign_sign(+Text, -Fault) is semidet.
%
%   Fault, fault(Start, End, Format, Args), is about the first sign of another language in Text, which
%   cannot be read. What stands in quotes or comments counts for nothing.

foreign_sign(Text, fault(Start, End, Format, Args)) :-
    string_codes(Text, Codes),
    scan(Codes, 0, Start, End, Format, Args).

scan([Code|Codes], At, Start, End, Format, Args) :-
    (   skipped(Code, Codes, Length, Rest)
    ->  Next is At + Length,
        scan(Rest, Next, Start, End, Format, Args)
    ;   token([Code|Codes], Token, Length, Rest)
    ->  (   wrong(Token, Rest, More, Format, Args)
        ->  Start = At,
            End is At + Length + More
        ;   Next is At + Length,
            scan(Rest, Next, Start, End, Format, Args)
        )
    ;   Next is At + 1,
        scan(Codes, Next, Start, End, Format, Args)
    ).

%   A quotation, or a comment to the end of the line.
skipped(Quote, Codes, Length, Rest) :-
    memberchk(Quote, [0'', 0'", 0'`]),
    nth1(Index, Codes, Quote),
    !,
    length(Inside, Index),
    append(Inside, Rest, Codes),
    Length is Index + 1.
skipped(0'%, Codes, Length, Rest) :-
    (   nth1(Index, Codes, 0'\n)
    ->  true
    ;   length(Codes, Index)
    ),
    length(Inside, Index),
    append(Inside, Rest, Codes),
    Length is Index + 1.

token([Code|Codes], Token, Length, Rest) :-
    (   code_type(Code, digit)
    ->  Kind = number
    ;   code_type(Code, csymf)
    ->  Kind = word
    ;   memberchk(Code, `#$&*+-/:<=>?@^~\\!|`)
    ->  Kind = sign
    ;   Code > 127
    ->  Kind = single
    ),
    (   Kind == single
    ->  Run = [], Rest = Codes
    ;   run(Codes, Kind, Run, Rest)
    ),
    length([Code|Run], Length),
    atom_codes(Atom, [Code|Run]),
    Token =.. [Kind, Atom].

run([Code|Codes], Kind, [Code|Run], Rest) :-
    goes_on(Kind, Code, Codes),
    !,
    run(Codes, Kind, Run, Rest).
run(Rest, _, [], Rest).

goes_on(number, Code, _) :- code_type(Code, digit).
goes_on(number, 0'., [Next|_]) :- code_type(Next, digit).
goes_on(word, Code, _) :- code_type(Code, csym).
goes_on(sign, Code, _) :- memberchk(Code, `#$&*+-/:<=>?@^~\\!|`).

wrong(sign(Sign), _, 0, Format, []) :-
    Sign \== '|',                       % of a list, too
    sign_advice(Sign, Format).
wrong(single(Sign), _, 0, Format, []) :-
    sign_advice(Sign, Format).
wrong(word(Word), Rest, 0, Format, Args) :-
    (   Rest = [0'(|_]
    ->  sub_atom(Word, 0, 1, _, First),
        char_type(First, upper),
        downcase_atom(Word, Small),
        Format = "a name with a capital letter is a variable: write ~w(...)",
        Args = [Small]
    ;   downcase_atom(Word, Small),
        memberchk(Small, [and, or, not, in, between]),
        sign_advice(Small, Format),
        Args = []
    ).
wrong(number(Number), Rest0, More, Format, [Metres, Number, Unit]) :-
    blanks(Rest0, 0, Blanks, Rest1),
    token(Rest1, word(Unit), Length, Rest),
    \+ Rest = [0'(|_],
    metres_of(Unit, Size),
    atom_number(Number, Value),
    Metres is Value * Size,
    More is Blanks + Length,
    Format = "lengths in goals are in metres: write ~4g for ~w ~w".

blanks([Code|Codes], Count0, Count, Rest) :-
    code_type(Code, space),
    !,
    Count1 is Count0 + 1,
    blanks(Codes, Count1, Count, Rest).
blanks(Rest, Count, Count, Rest).
